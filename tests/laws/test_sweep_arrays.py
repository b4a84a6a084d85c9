"""What a sweep passes as arrays is what the same points give one by one, and its files are those
that Zarr writes.
"""

import numpy as np
import pytest

import symkin
from helpers.folders import same_files
from helpers.inside import make_space, read_given
from helpers.needed import Later, needs
from helpers.samples import three_rrr
from symkin import InputError, sweep

zarr = Later("zarr")
pytestmark = needs("zarr")


@pytest.mark.parametrize("name", ["zhang2009", "zhao2000", "yao2020", "gluon_6l3"])
def test_known_values_are_those_of_single_inputs(name):
    """Values and units of joints, angles of more than a turn included."""
    mechanism = symkin.load(name)
    ranges = {c.name: (100.0, 1000.0) for c in mechanism.actuated}
    space = make_space(mechanism, ranges, sample=30, seed=1)
    points = space.points((slice(0, 30),))
    known, off = space.known_values(points)
    one_by_one = [
        read_given(mechanism, space.given(point)["joints"], None).values for point in points
    ]
    np.testing.assert_allclose(known, one_by_one, rtol=1e-13)
    assert not off.any()


@pytest.mark.parametrize(
    ("name", "ranges", "at"),
    [
        ("zhang2009", {"x": (-20, 20), "z": (80, 120), "rx": (-9, 9), "rz": (-200, 200)}, None),
        ("zhao2000", {"x": (-20, 20), "gamma": (-200, 200)}, None),
        ("zhao2000", {"y": (-20, 20), "rz": (-200, 200)}, None),
        ("yao2020", {"x": (300, 301), "ry": (-5, 5)}, None),
    ],
)
def test_known_values_of_poses_are_those_of_single_poses(name, ranges, at):
    """Coordinates of the motion and how far a pose lies off what the mechanism can take."""
    mechanism = symkin.load(name)
    space = make_space(mechanism, ranges, over="poses", at=at, sample=20, seed=2)
    points = space.points((slice(0, 20),))
    known, off = space.known_values(points)
    givens = [read_given(mechanism, None, space.given(point)["pose"]) for point in points]
    np.testing.assert_allclose(
        known,
        [given.values for given in givens],
        rtol=1e-12,
        atol=1e-12 * mechanism.characteristic_length,
    )
    np.testing.assert_allclose(
        off, [given.off_motion for given in givens], atol=1e-12 * mechanism.characteristic_length
    )


def test_poses_are_one_of_two_things_swept_over(tmp_path):
    """`over` names what `poses` says yes or no to; the folders are the same."""
    mechanism = three_rrr("planar")
    size = mechanism.characteristic_length
    grid = {"x": np.linspace(-0.1, 0.1, 3) * size, "y": [0.0, 0.1 * size]}
    sweep(mechanism, grid, tmp_path / "over", over="poses", workers=0)
    sweep(mechanism, grid, tmp_path / "poses", poses=True, workers=0)
    assert same_files(tmp_path / "over", tmp_path / "poses")
    with pytest.raises(
        InputError,
        match=r"over = 'joints' is unknown \(do you mean 'inputs'\?\); allowed: inputs, poses",
    ):
        sweep(mechanism, grid, tmp_path / "none", over="joints", workers=0)
