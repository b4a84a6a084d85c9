"""Exported rates `of` by `by` against joint screws: at many closed configurations, turned,
scaled, and where one choice of rows fails."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.exported_jacobians import run_exported
from helpers.gate import in_gate
from helpers.inside import (
    POSE_CONDITIONS,
    as_graph,
    build_problem,
    closed_configurations,
    jacobian_text,
    link_poses,
    make_solution,
    many_elsewhere,
    variables_elsewhere,
)
from oracle.screw_rates import screw_rates
from symkin import Joint, LinkJoint, Mechanism, Pose

REGULAR = 1e-3
"""Least singular value by which `by` decide the motion (screws of unit size) of a configuration
that counts as regular."""
# machine, wanted rates, those of
CASES = [
    ("four_bar", ["follower", "crank_pin"], ["crank"]),
    ("stephenson_six_bar", ["crank", "output"], ["rocker"]),
    ("klann_leg", ["x", "y", "torsion"], ["crank"]),
    ("bricard", ["joint1", "joint3", "joint6"], ["joint2"]),
    ("goldberg", None, None),
    ("sarrus", ["head_x", "z"], ["foot_x"]),
    ("ankle", ["tilt", "azimuth", "upper_motor"], ["ankle.1", "ankle.2"]),
    ("double_wishbone", ["lower_hinge", "x"], ["z", "rack"]),
    ("spherical_wrist", ["elbow3", "azimuth"], ["motor1", "motor2", "motor3"]),
    ("zhao2000", ["theta1", "radial2", "torsion"], ["x", "y", "theta2", "op"]),
    ("zhang2009", ["leg1", "z"], ["leg2", "leg3", "leg4", "leg5", "leg6", "x"]),
    ("ur5e", ["q6", "q4", "y"], ["tilt", "q5", "q1", "q3", "x", "torsion"]),
]


def _moved(mechanism: Mechanism, quaternion: np.ndarray, factor: float) -> Mechanism:
    """The same machine as a graph in metres, elsewhere in its base frame, larger."""
    graph = as_graph(mechanism)
    by = Pose(factor * np.array([0.1, -0.2, 0.3]), quaternion / np.linalg.norm(quaternion))

    def point(v: Any) -> tuple[float, ...]:
        return tuple(np.asarray(by.apply(factor * np.array(v))))

    def turned(v: Any) -> tuple[float, ...] | None:
        return None if v is None else tuple(np.asarray(by.turn(np.array(v))))

    def joint(j: Joint) -> Joint:
        zero = factor * j.zero if j.type == "P" else j.zero
        return replace(
            j,
            point=point(j.point),
            axis=turned(j.axis),
            axis2=turned(j.axis2),
            zero=zero,
            pitch=factor * j.pitch,
            limits=None,
        )

    home = {}
    if graph.platform_link is not None:
        pose = by @ Pose(factor * np.array(graph.platform_position), graph.platform_quaternion)
        home = {
            "platform_position": tuple(pose.position),
            "platform_quaternion": tuple(pose.quaternion),
        }
    rods = [
        replace(
            r,
            start=point(r.start),
            end=point(r.end),
            length=None if r.length is None else factor * r.length,
            offset=factor * r.offset,
            limits=None,
        )
        for r in graph.link_rods
    ]
    joints = [replace(entry, joint=joint(entry.joint)) for entry in graph.link_joints]
    return replace(graph, link_joints=joints, link_rods=rods, link_points=(), **home)


def _names(
    mechanism: Mechanism, of: list[str] | None, by: list[str] | None
) -> tuple[list[str], list[str]]:
    """The names of a case; of a linkage of one freedom its first joint drives all others."""
    if of is not None and by is not None:
        return of, by
    names = [c.name for c in mechanism.coordinates]
    return names[1:], names[:1]


def _configurations(made: Any, seed: int) -> np.ndarray:
    """Closed ones, with azimuth and tilt as they are read off the orientation."""
    held = tuple(name for name in (*made.rows, *made.columns) if name not in POSE_CONDITIONS)
    plain = build_problem(made.mechanism, "given", (), held).closure
    return many_elsewhere(made.closure, plain, np.array(closed_configurations(plain, seed)))


def _compare(made: Any, configurations: np.ndarray) -> int:
    """The expression's and `at`'s matrices are that of screws, angles times the size, to 1e-9
    over how well `by` decide; returns at how many regular configurations."""
    mechanism, closure = made.mechanism, made.closure
    size = mechanism.characteristic_length
    units = {c.name: size if c.is_angular else 1.0 for c in closure.coordinates}
    weights = np.array(
        [[units[row] / units[column] for column in made.columns] for row in made.rows]
    )
    count = 0
    for z in configurations:
        solution = make_solution(made.expressions.problem, z)
        values = {
            name: float(np.ravel(v)[0])
            for name, v in solution.all_values.items()
            if np.size(v) == 1
        }
        expected, decided = screw_rates(
            mechanism, link_poses(closure, z[None]).at(0), values, made.rows, made.columns
        )
        if decided < REGULAR or not np.isfinite(expected).all():
            continue
        count += 1
        found = made.function.call([z[v.index] for v in made.inputs])[0].full()
        tolerance = 1e-9 / decided * max(float(np.abs(weights * expected).max()), 1e-2)
        for matrix in (found, made.at(solution)):
            assert np.abs(weights * (matrix - expected)).max() < tolerance, (
                made.rows,
                made.columns,
            )
    return count


@pytest.mark.parametrize(
    ("name", "of", "by"),
    in_gate(
        CASES,
        [c for c in CASES if c[0] in ("ankle", "bennett", "bricard", "ur5e", "zhao2000")],
    ),
)
def test_rates_are_those_of_screws(name: str, of: list[str] | None, by: list[str] | None) -> None:
    """At home, and turned at a random size from 1e-8 to 1e6."""
    rng = np.random.default_rng(len(name))
    home = symkin.load(name)
    of, by = _names(home, of, by)
    for mechanism in (home, _moved(home, rng.normal(size=4), 10.0 ** rng.integers(-8, 7))):
        try:
            made = symkin.jacobian(mechanism, of=of, by=by)
        except symkin.InputError:
            # x and y of a machine that has turned move together, and limbs of a restricted motion
            # are carried by joints
            assert mechanism is not home
            continue
        assert _compare(made, _configurations(made, 1)) >= 3


@cache
def _bricard() -> tuple[Any, np.ndarray]:
    """A Bricard linkage by a joint, and configurations of both its modes, among them some at
    which a row of each kind says nothing, though all together do."""
    mechanism = symkin.load("bricard")
    names = [c.name for c in mechanism.coordinates if c.name != "joint2"]
    made = symkin.jacobian(mechanism, of=names, by=["joint2"])
    modes = [
        m
        for v in (109.7809822, 109.780983, 60.0)
        for m in symkin.modes(mechanism, given={"joint2": v}, method="multistart", starts=60)
    ]
    return made, np.array([variables_elsewhere(made.closure, mode) for mode in modes])


def test_no_choice_of_rows_fails_at_a_regular_configuration() -> None:
    """Where a fixed choice of rows has a pole all rows have the rates of the screws."""
    made, configurations = _bricard()
    assert _compare(made, configurations) >= 5


@pytest.mark.parametrize(
    "language", ["numpy", pytest.param("sympy", marks=pytest.mark.long), "c", "casadi", "latex"]
)
def test_every_format_is_right_where_a_choice_of_rows_is_not(language: str, tmp_path: Path) -> None:
    """What is written has the rates that `at` has, as the file runs in its language."""
    made, configurations = _bricard()
    for values in configurations[:2]:
        inputs = [float(values[v.index]) for v in made.inputs]
        expected = made.at(make_solution(made.expressions.problem, values))
        assert run_exported(made, language, inputs, tmp_path) == pytest.approx(expected, rel=1e-9)


def _three_cranks() -> Mechanism:
    """A plate on three equal parallel cranks, the third of which carries it through the dead
    points of the two others."""
    pivots = [(0.0, 0.0), (100.0, 0.0), (50.0, 40.0)]
    crank = 30.0 * np.array([np.cos(0.7), np.sin(0.7)])

    def joint(name: str, at: Any, links: tuple[str, str]) -> LinkJoint:
        return LinkJoint(
            Joint(
                name, "R", (float(at[0]), float(at[1]), 0.0), (0.0, 0.0, 1.0), actuated=name == "a1"
            ),
            links,
        )

    joints = [joint(f"a{k}", at, ("base", f"crank{k}")) for k, at in enumerate(pivots, 1)]
    joints += [
        joint(f"b{k}", np.array(at) + crank, (f"crank{k}", "plate"))
        for k, at in enumerate(pivots, 1)
    ]
    return Mechanism("cranks", link_joints=joints, length_unit="mm", angle_unit="deg")


def test_redundant_rows_carry_through_dead_points_of_their_parts() -> None:
    """All cranks turn as the first one does, where two of them are in line with the plate too."""
    made = symkin.jacobian(_three_cranks(), of=["a2", "a3", "b1"], by=["a1"])
    slopes = {"a": 1.0, "b": -1.0}
    for angle in (0.2, -0.7, np.pi - 0.7):
        z = np.array([slopes[c.name[0]] * angle for c in made.closure.coordinates])
        assert made.function.call([z[v.index] for v in made.inputs])[0].full() == pytest.approx(
            np.array([[1.0], [1.0], [-1.0]])
        )
        assert made.at(make_solution(made.expressions.problem, z)) == pytest.approx(
            np.array([[1.0], [1.0], [-1.0]])
        )


LEVEL = [
    ("jansen_leg", "tilt", "crank"),
    ("jansen_leg", "azimuth,x", "crank"),
    ("sarrus", "tilt", "foot_x"),
    ("delta", "z,tilt", "motor1,motor2,motor3"),
    ("zhao2000", "tilt", "theta1,theta2,theta3,op"),
]


@pytest.mark.parametrize(("name", "of", "by"), in_gate(LEVEL, LEVEL[::2]))
def test_a_platform_that_never_tilts_has_no_rate_of_tilt(
    capsys: pytest.CaptureFixture[str], name: str, of: str, by: str
) -> None:
    """One sentence names the angle; torsion and joints of the same machine are written."""
    status, out, err = run(capsys, "jacobian", name, "--of", of, "--by", by, "--format", "numpy")
    assert (status, out, err.count("\n")) == (2, "", 1)
    angle = "tilt" if "tilt" in of else "azimuth"
    assert f"of: {angle} has no rate" in err
    assert (
        run(capsys, "jacobian", name, "--of", "torsion,z", "--by", by, "--format", "numpy")[0] == 0
    )


@pytest.mark.parametrize("name", ["ankle", "spherical_wrist"])
def test_a_platform_that_tilts_has_rates_of_tilt(
    capsys: pytest.CaptureFixture[str], name: str
) -> None:
    by = ",".join(c.name for c in symkin.load(name).actuated)
    assert (
        run(capsys, "jacobian", name, "--of", "tilt,azimuth", "--by", by, "--format", "numpy")[0]
        == 0
    )


def test_c_without_inputs_takes_variables(tmp_path: Path) -> None:
    """Gears turn at rates that depend on nothing: the signature is that of all others."""
    made = symkin.jacobian(symkin.load("planetary_gear"), of=["carrier"], by=["sun", "ring"])
    assert not made.inputs
    assert "_rates_jacobian(const double variables[], double jacobian[2])" in jacobian_text(
        made, "c"
    )
    assert run_exported(made, "c", [], tmp_path) == pytest.approx(made.function.call([])[0].full())
