"""A machine is followed by the same steps to the same stops, and has the same graph of modes and
loci, however it is written; what is told goes to the machine and back.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.inside import (
    BallReading,
    build_closure,
    displaced,
    lowered,
    many_as_written,
    many_of_machine,
)
from helpers.spellings import MACHINES, Spelling, named, spellings
from symkin import Joint, Limb, RodLimb, Track

SPELLED = ("limbs, motion", "limbs", "graph, turned")


def five_bars(folder: Path) -> list[Spelling]:
    return named(list(spellings(MACHINES["five-bar"](), folder)), SPELLED)


def told(track: Track) -> tuple[object, ...]:
    """What a track says that must not depend on how its machine is written."""
    stop = track.stop
    why = None
    if stop is not None:
        meeting = None if stop.meeting is None else (stop.meeting.own, stop.meeting.others)
        why = (stop.kind, stop.type, stop.kinds, stop.row, round(stop.u, 7), stop.limit, meeting)
    sigma = None if track.nearest is None else round(track.nearest.smallest_singular_value, 7)
    return (track.certified, track.steps, track.ground, why, sigma)


@pytest.mark.parametrize(
    "given",
    [
        {"crank1": [0.0, 120.0], "crank2": [0.0, -120.0]},
        {"crank1": [0.0, 720.0], "crank2": [0.0, 720.0]},
        {"elbow1": [0.0, -0.6], "crank1": [0.0, 0.3]},
    ],
    ids=["fold", "turns", "passive"],
)
def test_a_track_has_one_answer_in_all_spellings(tmp_path, given) -> None:
    """Without a declared motion, as a graph, turned in space: the same proved steps and stop, and
    the tip's angle with its whole turns.
    """
    found = [symkin.track(one.mechanism, given=given, samples=3) for one in five_bars(tmp_path)]
    assert len({told(track) for track in found}) == 1
    assert found[0].certified
    joints = [track.end.joints for track in found]
    for name in set.intersection(*map(set, joints)):
        assert np.ptp([there[name] for there in joints]) < 1e-6
    for track in found:
        size = track.trajectory.mechanism.characteristic_length
        assert track.residual < 1e-11 * size


def test_a_limit_of_a_joint_that_the_machine_does_without_is_met(tmp_path) -> None:
    """Of two crossing passive revolutes, which would be a universal joint, one has limits."""
    machine = MACHINES["Tricept"]()
    (one,) = named(list(spellings(machine, tmp_path)), ["limbs, R R for U"])
    mechanism = one.mechanism
    limbs = [
        replace(
            limb,
            joints=[
                replace(j, limits=(-0.05, 0.05)) if j.name == "cu_2" else j for j in limb.joints
            ],
        )
        if isinstance(limb, Limb) and not isinstance(limb, RodLimb)
        else limb
        for limb in mechanism.limbs
    ]
    limited = replace(mechanism, limbs=limbs)
    start = [c.reference[0] for c in limited.actuated]
    track = symkin.track(limited, joints=[start, [start[0] + 60.0, *start[1:]]])
    assert track.stop is not None
    assert track.stop.limit is not None
    assert track.stop.limit.name == "cu_2"
    assert abs(abs(track.end.joints["cu_2"]) - 0.05) < 1e-6


def test_a_graph_of_modes_is_proved_in_all_spellings(tmp_path) -> None:
    axes = [("crank1", -10.0, 10.0), ("crank2", -10.0, 10.0)]
    found = [symkin.mode_graph(one.mechanism, axes, 2) for one in five_bars(tmp_path)]
    assert all(graph.certified for graph in found)
    assert len({str(graph.groups) + str(graph.edges) for graph in found}) == 1


@pytest.mark.parametrize(
    ("name", "plane", "high", "kinds"),
    [("3-RRR", ("x", "y"), 0.0, ("type 1",)), ("five-bar", ("crank1", "crank2"), 60.0, None)],
    ids=["pose", "joints"],
)
def test_loci_are_one_in_all_spellings(tmp_path, name, plane, high, kinds) -> None:
    """Curves of a graph and of limbs without motion are those of declared limbs, by their kinds."""
    machine, curves = MACHINES[name](), []
    for one in named(list(spellings(machine, tmp_path)), ("limbs, motion", "limbs", "graph")):
        here = symkin.solve(one.mechanism).solution
        sides, chosen = [(-60.0, high)] * 2, {} if kinds is None else {"kinds": kinds}
        loci = symkin.singular_loci(here, plane, ranges=sides, starts=6, **chosen)
        curves.append([(c.kind, c.points) for c in loci.curves])
    assert curves[0]
    for other in curves[1:]:
        assert [kind for kind, _ in other] == [kind for kind, _ in curves[0]]
        for (_, a), (_, b) in zip(curves[0], other, strict=True):
            assert np.allclose(a, b, atol=1e-6)


def test_a_track_by_passive_joints_is_proved_of_limbs_as_of_a_graph(tmp_path) -> None:
    """A spherical 3-RRR by an elbow: limbs too are followed without rows that others imply."""
    machine = MACHINES["Agile Eye"]()
    given = {"elbow1": [0.0, 0.2], "motor1": 0.0, "motor2": 0.0}
    chosen = named(list(spellings(machine, tmp_path)), ("limbs, motion", "graph"))
    limbs, graph = (symkin.track(one.mechanism, given=given) for one in chosen)
    assert limbs.certified
    assert (limbs.steps, limbs.reached) == (graph.steps, graph.reached)


@pytest.mark.parametrize("spelling", ["limbs, R R for U", "graph, R R for U"])
def test_what_is_told_goes_to_the_machine_and_back(tmp_path, spelling) -> None:
    """Configurations of a turned Tricept with revolutes in place of its universal joint."""
    machine = MACHINES["Tricept"]()
    (one,) = named(list(spellings(machine, tmp_path)), [spelling])
    mechanism = displaced(one.mechanism, symkin.Pose.from_euler([1, 2, 3], [0.3, 0.5, 0.7]))
    low = lowered(mechanism)
    assert low is not None
    joints = list(machine.values.values())
    mode = symkin.solve(mechanism, joints=joints).solution
    own, there = build_closure(mechanism, mode.partition), build_closure(low.machine)
    taken = many_of_machine(there, own, mode.variables[None], low)
    back = many_as_written(own, there, taken, low)
    assert np.allclose(back, mode.variables, atol=1e-9)


def test_three_revolutes_are_the_ball_that_they_read() -> None:
    """R(a, t1) R(b, t2) R(c, t3), b normal to a and to c: angles to a quaternion and back, the
    second within a quarter turn of the reference.
    """
    rng = np.random.default_rng(0)
    for handed in (1.0, -1.0):
        b, other = rng.normal(size=(2, 3))
        a = np.cross(b, other)
        axes = zip("abc", (a, b, handed * np.cross(a, b)), strict=True)
        joints = [Joint(n, "R", (0.0, 0.0, 0.0), tuple(v / np.linalg.norm(v))) for n, v in axes]
        ball = BallReading((joints[0], joints[1], joints[2]), "ball")
        told = dict(zip("abc", rng.uniform(-1.5, 1.5, 3), strict=True))
        back = ball.values(ball.value({name: ca.SX(v) for name, v in told.items()}))
        assert all(abs(float(back[name]) - v) < 1e-12 for name, v in told.items())
