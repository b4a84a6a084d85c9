"""Which coordinates of a pose can be swept, what they mean, and sweeps of which hardly any point is
a pose.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.inside import make_space, poses_vary
from helpers.laws import axis_turn, ball_turn
from helpers.samples import Z, delta, five_bar, four_bar, pieper, three_rps, three_rrr
from symkin import InputError, Joint, Limb, Mechanism, sweep

SPATIAL = symkin.load("zhang2009")


def scara():
    """A serial arm of three vertical turning joints and a vertical sliding one."""
    turns = [Joint(f"q{k}", "R", (100.0 * k, 0, 0), Z, actuated=True) for k in range(3)]
    lift = Joint("lift", "P", axis=Z, actuated=True)
    return Mechanism(
        "scara", [Limb("scara", [*turns, lift])], serial=True, platform_position=(170.0, 90.0, 10.0)
    )


def cardan():
    """A platform on a universal joint about x and y, at their crossing."""
    joints = [
        Joint("a", "R", (0, 0, 0), (1.0, 0, 0), actuated=True),
        Joint("b", "R", (0, 0, 0), (0, 1.0, 0), actuated=True),
    ]
    return Mechanism("cardan", [Limb("cardan", joints)], serial=True)


@pytest.mark.parametrize(
    ("mechanism", "names"),
    [
        (SPATIAL, "x, y, z, rx, ry, rz"),
        (symkin.load("zhao2000"), "x, y, z, gamma, rz"),
        (three_rrr("planar"), "x, y, gamma, rz"),
        (delta(), "x, y, z"),
        (scara(), "x, y, z, rx, ry, rz"),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_axes_are_those_of_the_motion(mechanism, names):
    """What a motion holds is refused with the names that it has; what it has is accepted one at a
    time.
    """
    for name in {"x", "y", "z", "gamma", "rx", "ry", "rz"} - set(names.split(", ")):
        with pytest.raises(InputError, match=f"no '{name}' to sweep; allowed: {names}$"):
            make_space(mechanism, {name: [0.0, 0.1]}, over="poses")
    for name in names.split(", "):
        if mechanism.name != "scara":
            assert make_space(mechanism, {name: [0.0, 0.1]}, over="poses").shape == (2,)


def test_gamma_turns_from_the_reference_and_rz_from_the_base():
    """R = Rz(gamma) R_reference and R = Rz(rz) R_at; both angles together are refused."""
    turned = [math.cos(0.3), 0.0, 0.0, math.sin(0.3)]
    mechanism = replace(three_rrr("planar"), platform_quaternion=tuple(turned), angle_unit="deg")
    at = [1.0, 2.0, 0.0, math.cos(0.5), 0.0, 0.0, math.sin(0.5)]
    for name, start in (("gamma", turned), ("rz", at[3:])):
        pose = make_space(mechanism, {name: [0.0, 20.0]}, over="poses", at=at).given([20.0])["pose"]
        assert np.allclose(
            pose.rotation, axis_turn(Z, math.radians(20.0)) @ ball_turn(start), atol=1e-15
        )
        assert np.allclose(pose.position, at[:3])
    with pytest.raises(InputError, match="gamma and rz are given together"):
        make_space(mechanism, {"gamma": [0.0, 1.0], "rz": [0.0, 1.0]}, over="poses")


def test_a_base_off_the_motion_is_refused():
    """Where what is not swept lies off the platform's motion no point has a solution; within
    rounding it is accepted.
    """
    with pytest.raises(
        InputError, match="at: the pose lies off the planar motion of three_rrr's platform by 5 mm"
    ):
        make_space(three_rrr("planar"), {"x": [0.0, 1.0]}, over="poses", at=[0, 0, 5, 1, 0, 0, 0])
    assert (
        make_space(
            three_rrr("planar"), {"x": [0.0, 1.0]}, over="poses", at=[0, 0, 1e-9, 1, 0, 0, 0]
        ).size
        == 2
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mechanism", "ranges", "said"),
    [
        (
            five_bar(),
            {"x": [-50, 50], "y": [0, 90]},
            "2 freedoms of 6, so that x and y cannot vary alone",
        ),
        (
            replace(five_bar(), motion="planar"),
            {"x": [-50, 50], "y": [0, 90], "gamma": [-90, 90]},
            "2 freedoms of 3, so that x, y and gamma",
        ),
        (three_rps(), {"z": [250, 350], "x": [-10, 10]}, "3 freedoms of 6, so that z and x cannot"),
        (three_rps(), {"rx": [-0.2, 0.2], "ry": [-0.2, 0.2]}, "rx and ry"),
        (four_bar()[0], {"x": [-20, 20]}, "1 freedom of 6, so that x"),
        pytest.param(
            three_rrr(), {"x": [-20, 20], "z": [-20, 20]}, "x and z", marks=pytest.mark.long
        ),
        (scara(), {"x": [0, 100], "rx": [-1, 1]}, "the tool of scara has 4"),
        (cardan(), {"rx": [-1, 1], "ry": [-1, 1]}, "rx and ry"),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_poses_under_a_condition_are_refused(tmp_path, mechanism, ranges, said):
    """Where the joints tie what is swept to itself or to what is held, nearly every point of a grid
    would be impossible.
    """
    with pytest.raises(InputError, match=said):
        sweep(mechanism, ranges, tmp_path / "s", poses=True, workers=0)
    assert not (tmp_path / "s").exists()
    with pytest.raises(InputError, match=said):
        make_space(mechanism, ranges, over="poses", sample=9)


@pytest.mark.parametrize(
    ("mechanism", "ranges"),
    [
        (three_rps(), {"z": [250, 350]}),
        (three_rrr(), {"x": [-20, 20], "y": [-20, 20], "rz": [-0.1, 0.1]}),
        (replace(delta(), motion="spatial"), {"x": [-20, 20], "z": [-200, -180]}),
        (scara(), {"x": [0, 99], "z": [0, 9], "rz": [-1, 1]}),
        (cardan(), {"rx": [-1, 1]}),
        (cardan(), {"ry": [-1, 1]}),
        (pieper(), {"x": [50, 90], "rx": [-0.1, 0.1]}),
        (three_rrr("planar"), {"x": [500, 900], "gamma": [-1, 1]}),
        (five_bar(), {"x": [0.0]}),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_poses_without_a_condition_are_accepted(mechanism, ranges):
    """Subgroups of displacements can be swept without declared motion; out of reach is no
    condition, one point needs none.
    """
    make_space(mechanism, ranges, over="poses")


def test_condition_is_told_where_it_holds():
    """A universal joint can turn about its second axis alone only where the first stands at rest;
    nothing is said of poses of which none closes.
    """
    box = (("ry", -1.0, 1.0),)
    assert poses_vary(cardan(), (0, 0, 0, 1, 0, 0, 0), box) is True
    assert poses_vary(cardan(), (0, 0, 5, 1, 0, 0, 0), box) is None


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"grid": "leg1=0:1:2"}, "grid = 'leg1=0:1:2' is of type str; a mapping"),
        ({"grid": [("leg1", [1.0])]}, "a mapping"),
        ({"mechanism": "zhang2009"}, "a Mechanism is needed"),
        ({"directory": 5}, "directory = 5; a path"),
        ({"at": "1,2"}, "list of numbers, a mapping or a Pose"),
        ({"random": 2.5}, "random = 2.5; a whole number"),
        ({"seed": "0"}, "seed = '0'; a whole number"),
        ({"starts": "many"}, "starts = 'many'"),
        ({"chunk": True}, "chunk = True; a whole"),
        ({"workers": 1.0}, "workers = 1.0"),
        ({"poses": "yes"}, "True or False"),
        ({"certify": 1}, "True or False"),
        ({"executor": 4}, "Executor is needed"),
        ({"dask": 8786}, "dask = 8786; a text"),
        ({"progress": 1}, "a function"),
        ({"grid": {"leg1": "0:1:2"}}, "no list of numbers"),
        ({"grid": {"leg1": None}}, "no list of numbers"),
        ({"grid": {1: [1.0]}}, "has no 1 to sweep"),
        ({"quantity": 3}, "quantity = 3"),
    ],
)
def test_wrong_types_are_refused(tmp_path, arguments, said):
    """Each is a sentence that says what is wanted, and leaves no folder."""
    given = {
        "mechanism": SPATIAL,
        "grid": {"leg1": [140.0]},
        "directory": tmp_path / "s",
        **arguments,
    }
    with pytest.raises(InputError, match=said):
        sweep(**given)
    assert not (tmp_path / "s").exists()


def test_counts_of_numpy_are_whole_numbers(tmp_path):
    """An integer of any type is taken as one."""
    pytest.importorskip("xarray")
    counts = {
        "chunk": np.int64(1),
        "workers": np.int32(0),
        "seed": np.uint8(3),
        "starts": np.int64(50),
    }
    assert (
        sweep(
            three_rrr("planar"), {"x": [0.0, 1.0]}, str(tmp_path / "s"), poses=True, **counts
        ).points
        == 2
    )
