"""Rates of any coordinates by those of any others, against central differences of configurations;
verbs that take no graph.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import symkin
from helpers import jacobian_cases as cases
from helpers.command_line import run
from helpers.gate import in_gate
from helpers.graph_twin import graph_twin
from helpers.inside import build_closure, variables_elsewhere
from helpers.moved_points import tricept
from helpers.samples import five_bar, three_rps, three_rrr
from symkin import Coupling, Joint, LinkJoint, Mechanism, Solution

CASES = [
    ("four_bar", ["follower", "crank_pin"], {"crank": 60.0}),
    ("four_bar", ["crank"], {"follower": 20.0}),
    ("slider_crank", ["piston"], {"crank": 50.0}),
    ("stephenson_six_bar", ["crank", "rocker"], {"output": 2.0}),
    ("klann_leg", ["x", "y"], {"crank": 100.0}),
    ("ankle", ["upper_motor", "lower_motor"], {"ankle.1": 10.0, "ankle.2": 5.0}),
    ("ankle", ["tilt", "azimuth", "ankle.2"], {"upper_motor": 8.0, "lower_motor": 12.0}),
    ("double_wishbone", ["lower_hinge", "x"], {"z": 340.0, "rack": 5.0}),
    ("planetary_gear", ["carrier"], {"sun": 50.0, "ring": 10.0}),
    ("bennett", ["output", "crank_pin"], {"input": 40.0}),
    ("zhao2000", ["theta1", "radial2"], {"x": 5.0, "y": 3.0, "theta2": -160.0, "op": 100.0}),
    (
        "zhang2009",
        ["leg1", "z"],
        {"leg2": 300.0, "leg3": 280.0, "leg4": 320.0, "leg5": 300.0, "leg6": 310.0, "x": 5.0},
    ),
]
STEP = 1e-4
"""In the file's units: differences of configurations closed to 1e-13 are exact to about 1e-8."""


def value(solution: Solution, name: str) -> float:
    """A coordinate in radians or the length unit."""
    if name in solution.joints:
        return float(solution.all_values[name])
    w, _, _, z = solution.quaternion
    match name:
        case "x" | "y" | "z":
            return float(solution.position["xyz".index(name)])
        case "tilt":
            return float(np.arccos(solution.rotation[2, 2]))
        case "azimuth":
            return float(np.arctan2(solution.rotation[1, 2], solution.rotation[0, 2]))
    return float(2 * np.arctan2(z, w))


@pytest.mark.parametrize(
    ("name", "of", "given"),
    in_gate(CASES, [case for case in CASES if case[0] not in ("double_wishbone", "zhao2000")]),
)
def test_rates_are_central_differences(name: str, of: list[str], given: dict[str, float]) -> None:
    """J is the slope of the configurations that solve finds beside one, from which they start; the
    expression gives the same.
    """
    mechanism = symkin.load(name)
    here = symkin.solve(mechanism, given=given).solution
    assert here is not None
    found = symkin.jacobian(mechanism, of=of, by=list(given))
    assert found.shape == (len(of), len(given))
    start = {n: v for n, v in here.joints.items() if isinstance(v, float) and n not in given}
    if not mechanism.is_graph:
        start = {"pose": [*here.position, *here.quaternion]}
    expected = np.empty(found.shape)
    for k, changed in enumerate(given):
        ends = [
            symkin.solve(
                mechanism, given=given | {changed: given[changed] + sign * STEP}, start=start
            ).solution
            for sign in (1, -1)
        ]
        apart = value(ends[0], changed) - value(ends[1], changed)
        expected[:, k] = [
            np.remainder(value(ends[0], n) - value(ends[1], n) + np.pi, 2 * np.pi) - np.pi
            for n in of
        ]
        expected[:, k] /= apart
    numbers = found.at(here)
    assert numbers == pytest.approx(expected, rel=1e-4, abs=1e-5)
    values = variables_elsewhere(found.closure, here)
    assert np.asarray(
        found.function.call([values[v.index] for v in found.inputs])[0]
    ) == pytest.approx(numbers, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "of", "given"),
    [CASES[0], CASES[5], ("bennett", ["output"], {"input": 40.0})],
)
def test_second_derivatives_are_slopes_of_the_first(
    name: str, of: list[str], given: dict[str, float]
) -> None:
    """dJ/dq_k, and dJ/dt along the rates of one coordinate, are central differences of J."""
    mechanism = symkin.load(name)
    here = symkin.solve(mechanism, given=given).solution
    assert here is not None
    found = symkin.jacobian(mechanism, of=of, by=list(given))
    start = {n: v for n, v in here.joints.items() if isinstance(v, float) and n not in given}
    bent = found.hessian_at(here)
    assert bent.shape == (len(given), *found.shape)
    for k, changed in enumerate(given):
        ends = [
            symkin.solve(
                mechanism, given=given | {changed: given[changed] + sign * 1e-2}, start=start
            ).solution
            for sign in (1, -1)
        ]
        apart = value(ends[0], changed) - value(ends[1], changed)
        slope = (found.at(ends[0]) - found.at(ends[1])) / apart
        assert bent[k] == pytest.approx(slope, rel=1e-5, abs=1e-6)
        along = found.time_derivative_at(here, np.eye(len(given))[k])
        assert along == pytest.approx(bent[k], rel=1e-9, abs=1e-12)


def test_rates_there_and_back_are_inverse() -> None:
    mechanism = symkin.load("ankle")
    here = symkin.solve(mechanism, given={"ankle.1": 10.0, "ankle.2": 5.0}).solution
    motors, joints = ["upper_motor", "lower_motor"], ["ankle.1", "ankle.2"]
    there = symkin.jacobian(mechanism, of=motors, by=joints).at(here)
    back = symkin.jacobian(mechanism, of=joints, by=motors).at(here)
    assert there @ back == pytest.approx(np.eye(2), abs=1e-9)


KINDS = ["direct", "inverse", "analytic", "passive"]
MADE = {"3-RRR": three_rrr, "3-RPS": three_rps, "five-bar": five_bar, "Tricept": tricept}


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *(("zhang2009", kind) for kind in KINDS[:3]),
        *((name, kind) for name in ("zhao2000", "3-RRR", "3-RPS") for kind in KINDS),
        ("five-bar", "passive"),
        ("Tricept", "passive"),
    ],
)
def test_a_graph_has_the_jacobians_of_the_limbs_that_it_is(name: str, kind: str) -> None:
    """Matrices of limbs and of their graph at one configuration, told by pose and joints (six
    lengths have mirrored poses, equally near to a flat reference); of passive joints both tell all,
    those at which loops are cut too.
    """
    limbs = MADE.get(name, partial(symkin.load, name))()
    graph = graph_twin(limbs)
    here = symkin.solve(limbs).solution
    start = {n: v for n, v in here.joints.items() if isinstance(v, float)}
    there = symkin.solve(graph, joints=here.actuated_values, start=start | {"pose": here.pose})
    own = symkin.jacobian(limbs, kind)
    found = symkin.jacobian(graph, kind)
    numbers = found.at(there.solution)
    assert found.columns == own.columns
    assert found.rows == own.rows
    assert numbers == pytest.approx(own.at(here), rel=1e-7, abs=1e-7)


def test_a_graph_of_more_motors_than_freedoms_has_the_jacobians_of_its_limbs() -> None:
    limbs = cases.case("redundant actuation").mechanism
    here = symkin.solve(limbs).solution
    for kind in ("direct", "inverse"):
        own, found = (symkin.jacobian(m, kind) for m in (limbs, graph_twin(limbs)))
        assert found.at(here) == pytest.approx(own.at(here), abs=1e-9)


def test_a_graph_has_the_inverse_jacobian_of_its_limbs_where_these_are_singular() -> None:
    """At the reference of a platform with all rods in one plane, of type 2, rates by a twist are
    finite, and the direct ones are not.
    """
    limbs = symkin.load("zhang2009")
    graph, reference = graph_twin(limbs), build_closure(limbs).reference
    own, found = (symkin.jacobian(m, "inverse").at(reference) for m in (limbs, graph))
    assert found == pytest.approx(own, abs=1e-9)
    assert not np.isfinite(symkin.jacobian(graph).at(reference)).all()


@pytest.mark.parametrize("listed", [(2, 3, 0, 1), (3, 1, 2, 0)])
def test_columns_of_an_arm_are_those_of_its_joints_in_whatever_order(listed: tuple[int, ...]):
    """Twists, rates and second derivatives of an arm whose joints a graph lists in another order
    than they stand, with a joint beside it that moves no platform, are those of the arm.
    """
    chain = [
        ("a", "R", (0, 0, 0), (0, 0, 1), ("base", "l1")),
        ("b", "R", (10, 0, 5), (0, 1, 0), ("l1", "l2")),
        ("c", "P", (30, 0, 5), (0, 0.6, 0.8), ("l2", "platform")),
        ("beside", "R", (12, 3, 4), (1, 0, 0), ("l1", "finger")),
    ]
    joints = [
        LinkJoint(Joint(name, kind, point, axis, actuated=True), links)
        for name, kind, point, axis, links in chain
    ]
    plain, mixed = (
        Mechanism("arm", link_joints=[joints[k] for k in order], platform_position=(25, 40, 0))
        for order in ((0, 1, 2), listed)
    )
    values = {"a": 0.2, "b": 0.3, "c": 4.0}
    here = symkin.solve(plain, given=values).solution
    there = symkin.solve(mixed, given=values | {"beside": 0.1}).solution
    for kind, axis in (("direct", 1), ("inverse", 0), ("analytic", 1)):
        own, found = symkin.jacobian(plain, kind), symkin.jacobian(mixed, kind)
        names = found.columns if axis else found.rows
        places = [(own.columns if axis else own.rows).index(name) for name in names]
        assert names == tuple(joints[k].joint.name for k in listed if k < len(values))
        assert np.allclose(found.at(there), own.at(here).take(places, axis), atol=1e-9)
        second = own.hessian_at(here).take(places, 0).take(places, axis + 1)
        assert np.allclose(found.hessian_at(there), second, atol=1e-9)
        rates = np.array([0.3, -0.2, 0.5])
        slope = own.time_derivative_at(here, rates).take(places, axis)
        assert np.allclose(found.time_derivative_at(there, rates[places]), slope, atol=1e-9)


def test_rates_of_a_platform_of_loops_within_loops_are_differences() -> None:
    """The twist of an excavator's bucket by its cylinders, which no limbs carry."""
    mechanism = symkin.load("excavator_bucket")
    here = symkin.solve(mechanism).solution
    numbers = symkin.jacobian(mechanism).at(here)
    for k, c in enumerate(mechanism.actuated):
        ends = [
            symkin.solve(
                mechanism,
                given=dict(zip([a.name for a in mechanism.actuated], moved, strict=True)),
                start={n: v for n, v in here.joints.items() if isinstance(v, float)},
            ).solution
            for moved in (
                np.array(here.actuated_values) + sign * 1e-3 * np.eye(len(numbers.T))[k]
                for sign in (1, -1)
            )
        ]
        step = np.ptp([end.joints[c.name] for end in ends])
        assert numbers[:3, k] == pytest.approx(
            (ends[0].position - ends[1].position) / step, rel=1e-5, abs=1e-6
        )
        turn = ends[0].rotation @ ends[1].rotation.T / step
        spin = [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
        assert numbers[3:, k] == pytest.approx(np.array(spin) / 2, rel=1e-5, abs=1e-6)
    inverse = symkin.jacobian(mechanism, "inverse").at(here)
    assert inverse @ numbers == pytest.approx(np.eye(len(mechanism.actuated)), abs=1e-9)


def test_values_of_what_is_read_suffice() -> None:
    linkage = symkin.load("four_bar")
    ratio = symkin.jacobian(linkage, of=["crank"], by=["crank"])
    assert ratio.inputs == ()
    assert ratio.at({}) == 1.0


def test_a_singular_configuration_has_no_rates() -> None:
    """At the dead centre of a slider-crank the piston does not decide the crank."""
    mechanism = symkin.load("slider_crank")
    angles = np.linspace(-180.0, 180.0, 73)
    ratio = symkin.jacobian(mechanism, of=["piston"], by=["crank"])
    slopes = [
        ratio.at(symkin.solve(mechanism, given={"crank": float(a)}).solution)[0, 0] for a in angles
    ]
    dead = float(angles[int(np.argmin(np.abs(slopes)))])
    found = symkin.solve(mechanism, given={"crank": dead}).solution
    if abs(ratio.at(found)[0, 0]) < 1e-9:
        with pytest.raises(symkin.SolveError, match="singular"):
            symkin.jacobian(mechanism, of=["crank"], by=["piston"]).at(found)


@pytest.mark.parametrize("language", ["casadi", "c", "numpy", "sympy", "latex"])
def test_every_format_is_written(capsys: pytest.CaptureFixture[str], language: str) -> None:
    status, out, err = run(
        capsys, "jacobian", "four_bar", "--of", "follower", "--by", "crank", "--format", language
    )
    assert (status, err) == (0, "")
    assert "rates" in out


REFUSED = [
    (["jacobian", "four_bar", "--format", "numpy"], "--of NAMES --by NAMES"),
    (
        ["jacobian", "four_bar", "--format", "numpy", "--kind", "inverse"],
        "whose rates the inverse Jacobian relates to those of",
    ),
    (["transmission", "five_link_suspension"], "1 stays free; no other joint moves with them"),
    (["jacobian", "four_bar", "--format", "numpy", "--of", "follower"], "give both"),
    (
        ["jacobian", "four_bar", "--format", "numpy", "--of", "folower", "--by", "crank"],
        "do you mean 'follower'?",
    ),
    (
        ["jacobian", "ankle", "--format", "numpy", "--of", "upper_motor", "--by", "ankle.1"],
        "1 freedom",
    ),
    (
        [
            "jacobian",
            "four_bar",
            "--format",
            "numpy",
            "--of",
            "follower",
            "--by",
            "crank",
            "--kind",
            "direct",
        ],
        "neither kind (--kind)",
    ),
    (["firmware", "four_bar", "-o", "fw"], "firmware takes limbs"),
]


@pytest.mark.parametrize(("arguments", "part"), REFUSED)
def test_what_takes_no_graph_says_so(
    capsys: pytest.CaptureFixture[str],
    tmp_path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    part: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, err = run(capsys, *arguments)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert part in err
    assert not list(tmp_path.iterdir())


def _geared_four_bar() -> Mechanism:
    """A four-bar whose coupler is the platform, its crank turned by two motors over a gear."""
    plain = symkin.load("four_bar")
    joints = [replace(e, joint=replace(e.joint, actuated=False)) for e in plain.link_joints]
    crank = next(e.joint for e in joints if e.joint.name == "crank")
    joints += [
        LinkJoint(Joint(name, "R", (0, 0, 10), (0, 0, 1), actuated=True), ("base", f"wheel {name}"))
        for name in ("slow", "fast")
    ]
    return replace(
        plain,
        link_joints=joints,
        couplings=[Coupling("crank", {"slow": 1.0, "fast": -2.0}, crank.zero)],
        platform_link="coupler",
        example=None,
    )


def test_joint_rates_of_a_twist_are_the_shortest_where_motors_move_the_platform_alike() -> None:
    """Of two motors with J = (a, -2 a) the rates of a twist are (a^+, -2 a^+) / 5, not huge ones
    that rounding makes.
    """
    mechanism = _geared_four_bar()
    here = symkin.solve(mechanism, given={"slow": 10.0, "fast": 20.0}).solution
    direct, inverse = (symkin.jacobian(mechanism, kind).at(here) for kind in ("direct", "inverse"))
    size = np.repeat([1.0, mechanism.characteristic_length], 3)
    assert inverse == pytest.approx(np.linalg.pinv(size[:, None] * direct) * size, rel=1e-9)


@pytest.mark.parametrize("size", [1e-8, 1e6])
def test_twists_keep_their_digits_at_all_sizes(size: float) -> None:
    """A slide that a screw carries, tied by a universal joint and a ball: velocities of the
    platform are proportional to the size, angular velocities are equal.
    """

    def loop(s: float) -> symkin.Jacobian:
        entries = [
            ("screw", "H", (0.3, -0.2, 0.5), (0.5, -0.7, 0.4), ("base", "nut")),
            ("slide", "P", (0.1, 0.4, 0.2), (0.6, 0.1, -0.8), ("nut", "table")),
            ("cross", "U", (0.9, 0.3, 0.7), (0.1, 0.9, 0.3), ("table", "strut")),
            ("ball", "S", (-0.4, 1.1, 0.2), None, ("strut", "base")),
        ]
        joints = [
            LinkJoint(
                Joint(
                    name,
                    kind,
                    tuple(s * v for v in point),
                    axis,
                    (0.9, -0.1, 0.0) if kind == "U" else None,
                    pitch=0.3 * s if kind == "H" else 0.0,
                    actuated=kind == "H",
                ),
                links,
            )
            for name, kind, point, axis, links in entries
        ]
        return symkin.jacobian(
            Mechanism(
                "press",
                link_joints=joints,
                platform_link="table",
                platform_position=(0.5 * s, 0.6 * s, 0.0),
            )
        )

    numbers = [made.at(made.closure.reference) for made in (loop(1.0), loop(size))]
    numbers[1][:3] /= size
    assert numbers[1] == pytest.approx(numbers[0], rel=1e-9)
