"""Angles of poses mean one thing in planes of loci, in grids of sweeps and in `solve`: a locus
point is singular in all.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pytest

import symkin
from helpers.inside import SINGULAR_VALUE
from helpers.laws import axis_turn
from helpers.samples import Z, three_rrr
from symkin import InputError, Loci, singular_loci, sweep

HEXAPOD = symkin.load("zhang2009")
TURNED = (math.cos(0.2), 0.1, -0.15, math.sqrt(math.sin(0.2) ** 2 - 0.1**2 - 0.15**2))
"""An orientation that commutes with no turn about a base axis."""


def pose_of(at: Sequence[float], values: Mapping[str, float]) -> list[float]:
    """x, y, z replaced; the rotation vector's quaternion (cos a/2, sin a/2 r/a) before the one
    held.
    """
    position = [values.get(name, at[k]) for k, name in enumerate("xyz")]
    r = np.radians([values.get(name, 0.0) for name in ("rx", "ry", "rz")])
    half = 0.5 * float(np.linalg.norm(r))
    c, s = math.cos(half), 0.5 * np.sinc(half / math.pi) * r
    w, u = at[3], np.array(at[4:])
    return [*position, c * w - s @ u, *(c * u + w * s + np.cross(s, u))]


def loci_of(
    at: Sequence[float], plane: tuple[str, str], half: Sequence[float], starts: int
) -> Loci:
    solution = symkin.solve(HEXAPOD, pose=at).solution
    centre = [at["xyz".index(name)] if name in "xyz" else 0.0 for name in plane]
    ranges = [(c - h, c + h) for c, h in zip(centre, half, strict=True)]
    return singular_loci(solution, plane, ranges=ranges, kinds=("type 2",), starts=starts)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    ("plane", "half"),
    [
        (("rx", "ry"), (100, 100)),
        (("rz", "ry"), (100, 100)),
        (("y", "rx"), (150, 100)),
        (("rz", "x"), (120, 80)),
    ],
)
def test_points_of_loci_are_singular_for_solve_and_in_sweeps(plane, half, tmp_path) -> None:
    """With rx, ry, rz one rotation vector before the orientation held, every point of a locus is a
    singular pose.
    """
    at = [20.0, 10.0, 150.0, *TURNED]
    loci = loci_of(at, plane, half, 4)
    points = np.vstack([curve.points for curve in loci.curves])
    inner = points[
        np.all(np.abs(points - np.mean(loci.ranges, axis=1)) < 0.8 * np.array(half), axis=1)
    ]
    for k, (u, v) in enumerate(inner[:: len(inner) // 3][:3]):
        values = dict(zip(plane, (float(u), float(v)), strict=True))
        found = symkin.singularity(symkin.solve(HEXAPOD, pose=pose_of(at, values)).solution)
        assert "type 2" in found.kinds
        assert found.distances["type 2"] < 1e-9
        grid = {name: [value] for name, value in values.items()}
        data = sweep(
            HEXAPOD, grid, tmp_path / str(k), poses=True, at=at, quantity="conditioning", workers=0
        ).open()
        assert float(data["distance_type_2"].min()) < SINGULAR_VALUE
        assert symkin.singularity(HEXAPOD, **loci.given((u, v))).distances["type 2"] < 1e-9


@pytest.mark.slow
def test_components_of_a_rotation_vector_have_no_period() -> None:
    """Over the whole turn of two components every point is a zero; a curve of one point would be
    none.
    """
    loci = loci_of([20.0, 10.0, 150.0, 1, 0, 0, 0], ("rx", "ry"), (180, 180), 6)
    assert loci.curves
    assert not any(curve.is_point for curve in loci.curves)
    assert max(curve.largest_row for curve in loci.curves) < 1e-9


@pytest.mark.slow
def test_gamma_and_rz_of_a_planar_platform_differ_by_the_orientation_held() -> None:
    """gamma counts from the reference and rz from the configuration: the same poses, singular in
    one working mode.
    """
    mechanism = three_rrr("planar")
    at = [5.0, 3.0, 0.0, math.cos(0.15), 0.0, 0.0, math.sin(0.15)]
    solution = symkin.solve(mechanism, pose=at).solution
    turn = mechanism.angle_out(0.3)
    side = mechanism.angle_out(1.0)
    by_gamma = singular_loci(
        solution,
        ("x", "gamma"),
        ranges=((-30, 30), (turn - side, turn + side)),
        kinds=("type 2",),
        starts=3,
    )
    by_rz = singular_loci(
        solution, ("x", "rz"), ranges=((-30, 30), (-side, side)), kinds=("type 2",), starts=6
    )
    for point in by_rz.of("type 2")[0].points[::50]:
        pose = by_rz.given(point)["pose"]
        same = by_gamma.given(point + [0.0, turn])["pose"]
        assert np.allclose(
            pose.rotation, axis_turn(Z, 0.3 + mechanism.angle_in(point[1])), atol=1e-12
        )
        assert np.allclose(pose.rotation, same.rotation, atol=1e-12)
        modes = symkin.modes(mechanism, pose=pose, method="multistart", starts=100)
        assert min(symkin.singularity(mode).distances["type 2"] for mode in modes) < 1e-7
    assert "gamma = rz + " in str(by_rz)
    with pytest.raises(InputError, match="the same angle"):
        singular_loci(solution, ("gamma", "rz"))


def test_what_angles_mean_is_said() -> None:
    """In the JSON, in the text and on the axes of the picture."""
    from helpers.inside import figure_of_loci

    loci = loci_of([20.0, 10.0, 150.0, 1, 0, 0, 0], ("rx", "z"), (60, 60), 1)
    assert "one rotation vector in the base frame" in loci.to_dict()["angles"]
    assert "orientation (1, 0, 0, 0) turned by (rx, 0, 0)" in str(loci)
    assert "rx, ry, rz: one rotation vector" in str(loci)
    axes = figure_of_loci(loci).axes[0]
    assert axes.get_xlabel().startswith("rotation vector rx [deg]")
    assert axes.get_ylabel().startswith("z [mm]")
