"""Laws of tracks of loops whose rows are redundant: what follows from other rows needs no proof of
its own, and what does not is never said to be proved.
"""

from __future__ import annotations

import numpy as np
import pytest

import symkin
from helpers.inside import build_problem, path_systems, rows_suffice
from symkin import Joint, LinkJoint, Mechanism, Pose

TURN = Pose.from_rotation_vector([1, 2, 3], [0.4, 1.1, -0.3])
X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
LOOPS = {
    "parallel axes": [
        ("R", "base A", (0, 0, 10), Z),
        ("R", "A B", (0, 40, 25), Z),
        ("R", "B C", (99, 60, -20), Z),
        ("R", "C base", (110, 0, 50), Z),
    ],
    "slider-crank": [
        ("R", "base A", (0, 0, 0), Z),
        ("R", "A B", (0, 40, 10), Z),
        ("R", "B C", (85, 10, 20), Z),
        ("P", "C base", (85, 10, 0), X),
    ],
    "spherical": [
        ("R", "base A", (0, 0, 0), (1, 0, 0.1)),
        ("R", "A B", (0, 0, 0), (0.8, 0.5, 0.1)),
        ("R", "B C", (0, 0, 0), (0.1, 0.8, 0.7)),
        ("R", "C base", (0, 0, 0), (0, 0.2, 1)),
    ],
    "slides in a plane": [
        ("P", "base A", (0, 0, 0), X),
        ("P", "A B", (0, 0, 0), (1, 2, 0)),
        ("P", "B base", (0, 0, 0), (-1, 1, 0)),
    ],
    "one axis": [
        ("R", "base A", (0, 0, 0), Z),
        ("P", "A B", (0, 0, 0), Z),
        ("H", "B base", (0, 0, 0), Z),
    ],
    "screw across": [
        ("R", "base A", (0, 0, 0), Z),
        ("R", "A B", (30, 10, 0), Z),
        ("H", "B C", (30, 0, 0), Y),
        ("R", "C D", (30, 0, 0), Y),
        ("P", "D base", (0, 0, 0), X),
    ],
}


def loop(name: str, turn: Pose | None = None) -> Mechanism:
    """A loop, as it stands above or turned and moved; its first joint drives."""
    turn = Pose.identity() if turn is None else turn
    return Mechanism(
        "loop",
        length_unit="m",
        link_joints=[
            LinkJoint(
                Joint(
                    f"j{k}",
                    kind,
                    turn.apply(point),
                    turn.turn(axis),
                    actuated=k == 0,
                    **({"pitch": 40.0} if kind == "H" else {}),
                ),
                links.split(),
            )
            for k, (kind, links, point, axis) in enumerate(LOOPS[name])
        ],
    )


@pytest.mark.parametrize("name", LOOPS)
def test_a_loop_is_proved_wherever_it_stands_and_however_it_is_written(name, tmp_path):
    """Turned in space and as SDF, where more rows than unknowns are left, as where it stands."""
    turned, path = loop(name, TURN), tmp_path / "loop.sdf"
    symkin.convert(turned, path)
    ends = []
    for machine in (loop(name), turned, symkin.load(path)):
        found = symkin.track(machine, given={"j0": [0.0, 0.25]})
        assert found.reached
        assert found.certified
        assert found.ground.startswith("proved")
        ends.append([found.end.joints[c.name] for c in machine.coordinates])
    assert np.ptp(ends, axis=0).max() < 1e-9


def cranks(third: float, arm: tuple[float, float] = (0, 50)) -> Mechanism:
    """Two equal cranks and a third one beside them on one coupler, closed at the reference."""
    feet = {"one": (0, 0, 0), "two": (80, 0, 0), "three": (30, 20, 0)}
    pins = {name: (x + arm[0], y + arm[1], 0) for name, (x, y, _) in feet.items()}
    pins["three"] = (pins["three"][0] + third, pins["three"][1], 0)
    return Mechanism(
        "cranks",
        link_joints=[
            LinkJoint(
                Joint(f"{name}{end}", "R", TURN.apply(point), TURN.turn(Z), actuated=drives), links
            )
            for name in feet
            for end, point, links, drives in (
                ("", feet[name], ("base", name), name == "one"),
                ("_pin", pins[name], (name, "coupler"), False),
            )
        ],
    )


def test_only_rows_that_follow_from_others_are_left_out_of_a_proof():
    """A third crank that is as long as the others moves with them; one that is not holds them."""
    moves = symkin.track(cranks(0.0), given={"one": [0.0, 0.5]})
    assert moves.reached
    assert moves.certified
    with pytest.raises(symkin.InputError, match="nothing moves one"):
        symkin.track(cranks(1e-3), given={"one": [0.0, 0.5]})


@pytest.mark.parametrize("arm", [(0, 50), (50, 0), (-50, 0)], ids=["upright", "dead", "folded"])
@pytest.mark.parametrize("third", [0.0, 1e-8, 1e-3, -5.0])
def test_rows_that_vanish_at_the_start_alone_do_not_suffice(third, arm):
    """All rows vanish at the start; those of a crank of another length vanish nowhere about it,
    even where the others alone would be singular.
    """
    problem = build_problem(cranks(third, arm), "direct")
    known, unknown = (
        problem.closure.reference[at] for at in (problem.known_places, problem.unknown_places)
    )
    (system,) = path_systems(problem)
    assert system.count > system.width
    root = unknown[system.places] / system.scale
    assert bool(rows_suffice(system, root[None], known[None])[0]) == (third == 0.0)


@pytest.mark.parametrize("turn", [None, TURN], ids=["home", "turned"])
def test_a_fold_of_redundant_rows_is_proved(turn):
    """The slide that a screw's link pushes reaches as far as the crank of (30, 10) lies along it:
    that is the first singularity, to the error that is proved.
    """
    found = symkin.track(loop("screw across", turn), given={"j4": [0.0, -2.0]})
    assert found.stop is not None
    assert (found.stop.kind, found.certified) == ("turning point", True)
    assert found.stop.error is not None
    reach = (np.hypot(30.0, 10.0) - 30.0) / 2.0
    assert abs(found.stop.place.parameter - reach) < found.stop.error + 1e-12
