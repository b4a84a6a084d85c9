"""`singularity` for coordinates that are told by name, of graphs and of limbs: hand cases, and
central differences of closed configurations.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import symkin
from helpers import samples
from helpers.command_line import run, run_json
from helpers.graph_twin import graph_twin
from symkin import InputError, Solution

STEP = 1e-3
"""In the file's units; central differences are exact to about its square over the size."""


def at(name: str, start: dict[str, float] | None = None, **given: float) -> Solution:
    found = symkin.solve(symkin.load(name), given=given, start=start).solution
    assert found is not None
    return found


def slopes(here: Solution, driver: dict[str, float]) -> dict[str, float]:
    """Central differences of all joints, in the file's units, along a regular motion: `driver` are
    known values and `here` a mode of them; the first one moves.
    """
    mechanism, name = here.mechanism, next(iter(driver))
    values = [
        symkin.track(
            mechanism,
            given={n: [v, v + sign * STEP] if n == name else v for n, v in driver.items()},
            start=here,
            limits=False,
        )
        for sign in (1.0, -1.0)
    ]
    assert all(found.reached for found in values)
    after, before = (found.end.joints for found in values)
    return {
        n: (after[n] - before[n]) / (2 * STEP) for n, v in after.items() if isinstance(v, float)
    }


def assert_along(motion: dict[str, float], expected: dict[str, float]) -> None:
    """The same direction, the largest rate 1."""
    largest = max(expected.values(), key=abs)
    for name, rate in expected.items():
        assert motion.get(name, 0.0) == pytest.approx(rate / largest, abs=1e-4), name


# --- one thing drives, another is at a dead point -------------------------------------------------


def dead_crank() -> Solution:
    """The four-bar where crank 40 and coupler 101 are in line: the rocker's end 141 from the
    crank's pivot.
    """
    x = (141.0**2 + 110.0**2 - 61.0**2) / (2 * 110.0)
    return at(
        "four_bar",
        {"follower": -28.0},
        crank=math.degrees(math.atan2(math.sqrt(141.0**2 - x * x), x)),
    )


def test_dead_points_of_a_four_bar() -> None:
    """Driven from the crank it is regular there, and the follower stands; driven from the follower
    it is type 2, and all others move as they do by the crank.
    """
    here = dead_crank()
    by_crank, by_follower = (
        symkin.singularity(here, given=[name]) for name in ("crank", "follower")
    )
    assert (by_crank.kinds, by_crank.motions, by_crank.rank_loss) == ((), (), 0)
    assert (by_follower.kinds, by_follower.conditions, by_follower.rank_loss) == (
        ("type 2",),
        ("RO", "II"),
        1,
    )
    (motion,) = by_follower.motions
    assert_along(motion, slopes(here, {"crank": here.joints["crank"]}))
    assert [group.loops for group in by_follower.groups] == [
        ("crank, crank_pin, follower_pin, follower",)
    ]
    named = symkin.singularity(here, given=["crank"], output=["follower"])
    assert (named.kinds, named.inputs) == (("type 1",), ({"crank": 1.0},))
    assert symkin.singularity(here, given=["follower"], output=["crank"]).kinds == ("type 2",)


@pytest.mark.parametrize("crank", [0.0, 180.0])
def test_dead_points_of_a_slider_crank(crank: float) -> None:
    """Crank 40 and rod 85 in line: with the piston held the rod turns by -40/85 of the crank's
    angle (180 apart: 40/85).
    """
    found = symkin.singularity(at("slider_crank", crank=crank), given=["piston"])
    assert found.kinds == ("type 2",)
    (motion,) = found.motions
    rod = (-1.0 if crank == 0.0 else 1.0) * 40.0 / 85.0
    assert motion["big_end"] / motion["crank"] == pytest.approx(rod - 1.0, rel=1e-6)
    assert motion["small_end"] / motion["crank"] == pytest.approx(-rod, rel=1e-6)
    assert "piston" not in motion
    assert symkin.singularity(at("slider_crank", crank=crank), output=["piston"]).kinds == (
        "type 1",
    )
    assert symkin.singularity(at("slider_crank", crank=90.0), given=["piston"]).kinds == ()


def test_a_singular_value_given_by_digits_is_reached_to_all_of_them() -> None:
    """The piston at 125 = 40 + 85, where solutions meet and are known to half of the digits, from
    the command's own start.
    """
    found = symkin.singularity(symkin.load("slider_crank"), given={"piston": 125.0})
    assert found.kinds == ("type 2",)
    assert found.distances["type 2"] < 1e-6


STOPS: list[tuple[str, dict[str, list[float]], dict[str, float], tuple[str, ...]]] = [
    ("stephenson_six_bar", {"crank": [0.0, 60.0]}, {"output": 0.0}, ("type 2",)),
    (
        "ankle",
        {"ankle.1": [0.0, -60.0], "ankle.2": [0.0, -30.0]},
        {"upper_motor": 0.0, "lower_motor": 0.0},
        ("passive",),
    ),
    ("four_bar", {"follower": [0.0, -60.0]}, {"crank": 0.0}, ("type 2",)),
    ("klann_leg", {"x": [0.0, -400.0]}, {"crank": 0.0}, ("type 2",)),
]


@pytest.mark.parametrize(("name", "path", "driver", "kinds"), STOPS)
def test_motions_at_a_stop_are_those_of_another_driver(
    name: str, path: dict[str, list[float]], driver: dict[str, float], kinds: tuple[str, ...]
) -> None:
    """Where a path stops at a turning point, the joints move as they do along the curve by a
    coordinate that is regular there.
    """
    mechanism = symkin.load(name)
    begin = symkin.solve(mechanism).solution
    assert begin is not None
    if "x" in path:
        path = {"x": [float(begin.position[0]), float(begin.position[0]) + path["x"][1]]}
    found = symkin.track(mechanism, given=path, start=begin if "x" in path else None)
    assert found.stop is not None
    assert found.stop.kind == "turning point"
    here = found.end.solution
    named = symkin.singularity(here, given=list(path))
    assert named.kinds == found.stop.kinds == kinds
    assert len(named.motions) == named.rank_loss == 1
    assert_along(named.motions[0], slopes(here, {n: here.joints[n] for n in driver}))
    (group,) = named.groups
    assert group == found.stop.groups[0]
    assert group.unknowns in [
        g.unknowns for g in symkin.modes(mechanism, given={n: v[0] for n, v in path.items()}).groups
    ]


# --- counts and distances -------------------------------------------------------------------------


def parallelogram() -> symkin.Mechanism:
    """Base and coupler 100, cranks 40, at right angles at the reference."""
    places = [
        ("a", "base", "left", (0, 0, 0)),
        ("b", "left", "coupler", (0, 40, 0)),
        ("c", "coupler", "right", (100, 40, 0)),
    ]
    places.append(("d", "base", "right", (100, 0, 0)))
    joints = [
        symkin.LinkJoint(
            symkin.Joint(name, "R", place, (0, 0, 1), actuated=name == "a"), [one, two]
        )
        for name, one, two, place in places
    ]
    return symkin.Mechanism("parallelogram", link_joints=joints, angle_unit="deg")


@pytest.mark.parametrize("motion", ["planar", "spatial"])
def test_more_freedoms_are_named_however_a_machine_is_written(motion) -> None:
    """Four pins on one line, two cranks of one length: the platform's velocity along the line
    vanishes, and both of its others are free. Limbs in space lose a wrench of theirs beside it,
    whose distance is told alike.
    """
    pins = [(0, "crank"), (10, "tip"), (30, "rocker"), (40, "end")]
    joints = [
        symkin.Joint(name, "R", (x, 0, 0), (0, 0, 1), actuated=name == "crank") for x, name in pins
    ]
    limbs = [symkin.Limb("left", joints[:2]), symkin.Limb("right", joints[2:])]
    flat = symkin.Mechanism("flat", limbs, platform_position=(10, 0, 0), motion=motion)
    for written in (flat, graph_twin(flat)):
        found = symkin.singularity(symkin.solve(written).solution)
        kinds = {"type 2", "increased"} | ({"constraint"} if motion == "spatial" else set())
        assert (set(found.kinds), found.conditions) == (kinds, ("RO", "IIM"))
        assert found.distances.get("constraint", 0.0) < 1e-6
        assert ("constraint" in found.distances) == (motion == "spatial")
        assert (found.ranks.freedoms, found.generic.freedoms) == (2, 1)
        assert "more freedoms than elsewhere" in str(found)


def test_a_flat_parallelogram_has_a_freedom_more() -> None:
    """At its change point two motions are free where elsewhere one is; with the crank held the
    follower turns.
    """
    mechanism = parallelogram()
    flat = symkin.singularity(mechanism, given={"a": -90.0}, start={"a": -89.0, "d": -89.0})
    assert set(flat.kinds) == {"type 2", "increased"}
    assert (flat.ranks.freedoms, flat.generic.freedoms, flat.rank_loss) == (2, 1, 1)
    assert flat.distances["increased"] < 1e-6
    (motion,) = flat.motions
    # coupler and follower are in line: the coupler's end moves 40 d = 100 c, b the coupler's turn
    assert motion["d"] == pytest.approx(1.0)
    assert motion["b"] == pytest.approx(0.4, abs=1e-6)
    regular = symkin.singularity(mechanism, given={"a": -45.0})
    assert regular.kinds == ()
    assert min(regular.distances.values()) > 1e-2


@pytest.mark.parametrize(
    ("name", "given", "output"),
    [
        ("four_bar", {"crank": 60.0}, "follower"),
        ("slider_crank", {"crank": 50.0}, "piston"),
        ("stephenson_six_bar", {"crank": 5.0}, "output"),
        ("bennett", {"input": 40.0}, "output"),
    ],
)
def test_the_map_of_one_rate_is_a_central_difference(
    name: str, given: dict[str, float], output: str
) -> None:
    """The singular value of driver to output, in lengths: angles times the size."""
    here = at(name, **given)
    mechanism = here.mechanism
    found = symkin.singularity(here, given=list(given), output=[output])
    units = {
        c.name: mechanism.characteristic_length * mechanism.angle_in(1.0) if c.is_angular else 1.0
        for c in mechanism.coordinates
    }
    slope = slopes(here, given)[output] * units[output] / units[next(iter(given))]
    assert found.singular_values == pytest.approx([abs(slope)], rel=1e-5)
    assert found.kinds == ()


def test_platform_maps_are_those_of_the_jacobian() -> None:
    """A graph with a platform, driven by its motors: singular values of q' -> twist are those of
    pose rates by central differences.
    """
    mechanism = symkin.load("ankle")
    motors = {"upper_motor": 8.0, "lower_motor": 12.0}
    here = symkin.solve(mechanism, given=motors).solution
    assert here is not None
    found = symkin.singularity(here)
    assert found.given == tuple(motors)
    size, columns = mechanism.characteristic_length, []
    for name in motors:
        after, before = (
            symkin.track(
                mechanism,
                given={n: [v, v + s * STEP] if n == name else v for n, v in motors.items()},
                start=here,
            ).end.pose
            for s in (1.0, -1.0)
        )
        spin = np.asarray(after.rotation) @ np.asarray(before.rotation).T
        turn = 0.5 * np.array(
            [spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]]
        )
        change = np.concatenate(
            [np.asarray(after.position) - np.asarray(before.position), size * turn]
        )
        columns.append(change / (2 * size * math.radians(STEP)))
    assert found.singular_values == pytest.approx(
        np.linalg.svd(np.array(columns), compute_uv=False), rel=1e-5
    )


@pytest.mark.parametrize("make", [samples.five_bar, samples.three_rrr, samples.delta])
def test_limbs_driven_by_name_are_limbs_driven_by_joints(make: Any) -> None:
    """All actuated joints by name are the same question; with the platform's motions the same kinds
    and singular values follow from the joints by name as from the pose.
    """
    mechanism = make()
    here = symkin.solve(mechanism).solution
    assert here is not None
    plain, named = (
        symkin.singularity(here),
        symkin.singularity(here, given=[c.name for c in mechanism.actuated]),
    )
    assert plain.to_dict() == named.to_dict()


def test_limbs_driven_by_their_platform() -> None:
    """A 3-RPS by height, azimuth and tilt: at the reference all legs follow."""
    mechanism = samples.three_rps()
    here = symkin.solve(mechanism, given={"z": 300.0, "azimuth": 0.3, "tilt": 0.2}).solution
    assert here is not None
    found = symkin.singularity(here, given=["z", "azimuth", "tilt"])
    assert (found.kinds, found.ranks.freedoms) == ((), 3)
    level = symkin.solve(mechanism, given={"z": 300.0, "azimuth": 0.3, "tilt": 0.0}).solution
    assert level is not None
    # tilt and azimuth are polar coordinates of a direction: that of a level platform moves no leg
    legs = [c.name for c in mechanism.actuated]
    polar = symkin.singularity(level, given=["z", "azimuth", "tilt"], output=legs)
    assert (polar.kinds, polar.inputs) == (("type 1",), ({"azimuth": 1.0},))


def test_a_pose_that_drives_a_platform_on_rods_alone() -> None:
    """Where nothing but the platform moves it is the output: a wheel's travel and the rack decide
    its pose.
    """
    here = at("five_link_suspension", rack=2.0, z=335.0)
    found = symkin.singularity(here, given=["rack", "z"])
    assert found.kinds == ()
    assert min(found.distances.values()) > 1e-3


def test_fewer_given_than_the_mobility_are_said() -> None:
    """A motor of two: one freedom is left everywhere, and that is said first and no kind."""
    found = symkin.singularity(
        at("ankle", upper_motor=5.0, lower_motor=3.0),
        given=["upper_motor"],
        output=["ankle.1", "ankle.2"],
    )
    assert found.kinds == ()
    assert found.uncontrolled_freedoms == 1
    assert any("given coordinates do not decide" in note for note in found.notes)
    text = str(found)
    assert "the given coordinates leave 1 freedom at every configuration" in text
    assert "\nregular\n" not in text


# --- what is said ---------------------------------------------------------------------------------


def test_json_and_text_and_picture(capsys: pytest.CaptureFixture[str], tmp_path) -> None:
    """The command's JSON holds what drives, the further motions, the block and its loop; the text
    says the same.
    """
    status, found = run_json(capsys, "singularities", "slider_crank", "--given", "piston=125")
    assert (status, found["given"], found["kinds"], found["rank_loss"]) == (
        0,
        ["piston"],
        ["type 2"],
        1,
    )
    assert found["blocks"][0]["loops"] == ["crank, big_end, small_end, piston"]
    assert found["motions"][0]["big_end"] == 1.0
    _, out, _ = run(capsys, "singularities", "slider_crank", "--given", "piston=125")
    for words in (
        "driven by: piston",
        "type 2 singularity, 1 further motion",
        "singular: block 0",
        "big_end 1",
    ):
        assert words in out
    symkin.singularity(at("slider_crank", crank=0.0), given=["piston"]).plot(tmp_path / "s.png")
    assert (tmp_path / "s.png").stat().st_size > 1000


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["four_bar", "--given", "folower=3"], "do you mean 'follower'?"),
        (["four_bar", "--given", "crank=10", "--output", "x"], "no platform link"),
        (["four_bar", "--given", "crank=10", "--output", "coupler"], "or joints by name"),
        (["four_bar", "--given", "crank=10", "--output", "crank"], "crank is given"),
        (
            ["four_bar", "--given", "crank=10", "--plane", "crank,follower"],
            "allowed: one or two of the coordinates that are given, crank",
        ),
        (["four_bar", "--plane", "crank,crank"], "one or two different coordinates"),
        (["four_bar", "--plane", "crank", "--range", "0:1,0:1"], "one is needed, for crank"),
        (["ankle", "--plane", "x,y"], "actuated joints upper_motor, lower_motor"),
        (
            ["ankle", "--given", "ankle.1=0,ankle.2=0", "--plane", "ankle.1,upper_motor"],
            "given, ankle.1, ankle.2",
        ),
        (["triad"], "no joint is actuated"),
        (
            ["ankle", "--given", "azimuth=3,tilt=2", "--output", "x"],
            "coordinates of the platform drive",
        ),
    ],
)
def test_mistakes_are_one_line(
    capsys: pytest.CaptureFixture[str], arguments: list[str], part: str
) -> None:
    status, out, err = run(capsys, "singularities", *arguments)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert part in err


@pytest.mark.parametrize("given", ["crank", {"crank": 3.0}, ["crank", "crank"], []])
def test_names_that_do_not_fit_are_refused(given: Any) -> None:
    here = at("four_bar", crank=60.0)
    if isinstance(given, dict):
        assert symkin.singularity(here, given=given).given == ("crank",)
        return
    with pytest.raises(InputError, match="given"):
        symkin.singularity(here, given=given)


def test_values_are_needed_with_a_mechanism() -> None:
    with pytest.raises(InputError, match="values by name"):
        symkin.singularity(symkin.load("four_bar"), given=["crank"])
