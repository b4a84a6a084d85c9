"""The study of the Gluon page as a reader runs it: rows against page and computation, rows quote
what was run.

Computed figures (pose of the example, its two solutions, shares of solutions) were found
independently, before the study was written; the closed form is held against another project's
(EAIK), the symbolic forward transform against symkin's forward on arms with parallel, antiparallel
and no parallel axes.
"""

from __future__ import annotations

import re

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.samples import pieper
from helpers.study_outcome import Outcome, assert_complete
from studies.gluon_6l3 import forward_transform
from symkin import Joint, Limb, Mechanism

pytestmark = [pytest.mark.slow, pytest.mark.long]

EXAMPLE = np.array(
    [
        [-0.39578, 0.81316, 0.42678, -144.03182],
        [-0.36487, 0.28723, -0.88565, -161.2822],
        [-0.84275, -0.50624, 0.18301, 489.30956],
    ]
)
"""Tool pose at 15 degrees each."""
SOLUTIONS = [[15.0] * 6, [15.0, 30.0, -15.0, 30.0, 15.0, 15.0]]


@pytest.fixture(scope="module")
def gluon(tmp_path_factory) -> Outcome:
    return Outcome("gluon_6l3", tmp_path_factory.mktemp("gluon"), "--poses", "20", "--points", "5")


def test_gluon_errata(gluon):
    assert_complete(gluon, ["[3,1] and [3,2]"])
    for name in ("arm", "guesses"):
        assert (gluon.folder / f"gluon_6l3_{name}.png").read_bytes().startswith(b"\x89PNG")


# --- forward --------------------------------------------------------------------------------------


def test_gluon_example(gluon):
    """The 4 x 4 result, rotation too, by the listing, the table, the sums of angles and symkin."""
    for i, row in enumerate(EXAMPLE):
        computed = gluon.number(f"T1 at 15 degrees each, row {i + 1}")
        assert computed[:3] == pytest.approx(row[:3], abs=6e-6)
        assert computed[3] == pytest.approx(row[3], abs=6e-5 if i == 1 else 6e-6)
    for beginning in (
        "A1 ... A6 as printed",
        "T1: listing 1 less",
        "T1: symkin less",
        "the same less the listing",
        "sums of angles",
    ):
        assert gluon.number(beginning) < 1e-9
    assert gluon.number("'the model gives one pose only'") == 1


def test_gluon_transform_is_written_in_sums_of_angles(gluon):
    """T[i, j] as printed, evaluated as text with the sines and cosines of DH angles, is the
    example's pose; angles 2, 3, 4 stand in it as sums, and no constant of rounding.
    """
    t = np.radians([15, -75, 15, -75, 15, 15])
    names = {"d1": 105.03, "a2": -174.42, "a3": -174.42, "d4": 75.66, "d5": 80.09, "d6": 44.36}
    for sums in ("1", "2", "23", "234", "5", "6"):
        angle = sum(t[int(k) - 1] for k in sums)
        names |= {f"c{sums}": np.cos(angle), f"s{sums}": np.sin(angle)}
    texts = [row["computed"] for row in gluon.rows("T[")]
    assert len(texts) == 12
    for text, value in zip(texts, EXAMPLE.ravel(), strict=True):
        assert value_of(text, names) == pytest.approx(value, abs=6e-5)
        assert "e-" not in text
    assert texts[6] == "-(c1 c5 + s1 c234 s5)"
    few, many = sorted(gluon.number("instructions: product of six"))
    assert few < 0.75 * many


def value_of(text: str, names: dict[str, float]) -> float:
    """Arithmetic of names, sums, brackets and products by juxtaposition."""
    tokens = re.findall(r"[a-z]\d+|[-+()]", text)

    def total() -> float:
        value, sign = 0.0, 1.0
        while tokens and tokens[0] != ")":
            if tokens[0] in "+-":
                sign = -1.0 if tokens.pop(0) == "-" else 1.0
            value += sign * product()
        return value

    def product() -> float:
        value = 1.0
        while tokens and tokens[0] not in ("+", "-", ")"):
            token = tokens.pop(0)
            if token == "(":
                value *= total()
                tokens.pop(0)
            else:
                value *= names[token]
        return value

    return total()


def arm_of(axes: list[tuple[str, tuple[float, float, float]]], seed: int) -> Mechanism:
    """A serial arm with these joints at random points."""
    rng = np.random.default_rng(seed)
    joints = [
        Joint(f"q{k}", kind, tuple(rng.uniform(-50, 50, 3)), axis, actuated=True)
        for k, (kind, axis) in enumerate(axes, start=1)
    ]
    return Mechanism(
        "arm", [Limb("arm", joints)], serial=True, platform_position=tuple(rng.uniform(-50, 50, 3))
    )


X, Y, Z, MINUS, SLANT = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -1, 0), (0.6, 0, 0.8)
ARMS = {
    "antiparallel": (
        [("R", Z), ("R", Y), ("R", MINUS), ("R", Y), ("R", X), ("R", Z)],
        [[1], [2, 3, 4], [5], [6]],
        {"2-3", "2-34"},
    ),
    "slide in a run": (
        [("R", Z), ("R", Z), ("P", X), ("R", Z)],
        [[1, 2, 3, 4]],
        {"1", "12", "124"},
    ),
    "slanted": (
        [("R", SLANT), ("R", SLANT), ("R", X), ("R", SLANT)],
        [[1, 2], [3], [4]],
        {"12", "3", "4"},
    ),
    "slide first": (
        [("P", SLANT), ("R", X), ("R", X), ("R", Y)],
        [[1, 2, 3], [4]],
        {"2", "23", "4"},
    ),
}


@pytest.mark.parametrize("name", ARMS)
def test_parallel_axes_add_up(name):
    """Law: for any serial mechanism the transform is symkin's forward, its runs are those of
    parallel axes, and sums are named.
    """
    joints, runs, sums = ARMS[name]
    arm = arm_of(joints, 3)
    found = forward_transform.forward_transform(forward_transform.chain_of(arm))
    assert [[k + 1 for k in run] for run in found.runs] == runs
    assert sums <= set(found.sums)
    assert_is_forward(arm, found.function())


def test_arms_of_other_studies():
    for arm in (pieper(), symkin.load("yao2020")):
        assert_is_forward(
            arm, forward_transform.forward_transform(forward_transform.chain_of(arm)).function()
        )


def assert_is_forward(arm: Mechanism, function: ca.Function) -> None:
    rng = np.random.default_rng(0)
    for q in rng.uniform(-3, 3, (3, len(arm.actuated))):
        values = [
            arm.angle_out(v) if c.is_angular else v for c, v in zip(arm.actuated, q, strict=True)
        ]
        pose = symkin.solve(arm, joints=values).solution.pose
        assert np.abs(np.asarray(function(q)) - pose.matrix).max() < 1e-10


# --- inverse --------------------------------------------------------------------------------------


def test_gluon_solutions(gluon):
    """The page gives the first; there are exactly two."""
    for k, expected in enumerate(SOLUTIONS, start=1):
        assert gluon.number(f"inverse, closed form, solution {k}") == pytest.approx(
            expected, abs=1e-9
        )
    assert not [
        r
        for r in gluon.content["rows"]
        if r["quantity"].startswith("inverse, closed form, solution 3")
    ]


def test_gluon_matched_elements(gluon):
    """The page's elements of A1^-1 T: [3,3] holds q5 alone, [3,4] too, [3,1] and [3,2] q5 and q6,
    [2,3] q234 and q5.
    """
    texts = {
        row["quantity"][:6]: row["computed"]
        for row in gluon.rows("B[")
        if "A2 ... A6" in row["quantity"]
    }
    assert texts == {
        "B[3,3]": "c5",
        "B[3,4]": "d4 + c5 d6",
        "B[3,1]": "s5 c6",
        "B[3,2]": "-s5 s6",
        "B[2,3]": "-s234 s5",
        "B[1,3]": "-c234 s5",
    }
    assert gluon.number("solutions with the wrist 50 mm").tolist() == [0, 0]
    assert [row["verdict"] for row in gluon.rows("(q1, q5, q6) left by the check")] == ["refuted"]


def test_gluon_from_zero_joints(gluon):
    """The page's ikine begins from zeros: the Jacobian has rank 3 there; its iteration ends at 15
    degrees each, CasADi's rootfinder fails, symkin begins beside and says so.
    """
    assert gluon.number("rank of J with zero joints") == 3
    for row in gluon.rows("ikine, the Jacobian's iteration"):
        assert row["computed"] == pytest.approx(SOLUTIONS[0], abs=1e-6)
    assert gluon.rows("rootfinder from zero joints")[0]["computed"] == "no solution"
    for solver in ("newton", "ipopt"):
        reached = gluon.number(f"symkin.solve, {solver}, from zero joints")
        assert min(np.abs(reached - solution).max() for solution in SOLUTIONS) < 1e-6
        assert "rank 3 of 6" in gluon.rows(f"symkin.solve, {solver}, what it says")[0]["computed"]


def test_gluon_jacobian(gluon):
    """Law: the symbolic Jacobian is the derivative, and its determinant the product of the three
    singularities' factors.
    """
    assert gluon.number("symbolic Jacobian less") < 1e-6
    assert gluon.number("det J") == pytest.approx([1, 1], abs=1e-6)
    assert gluon.number("rank of J with q3 = 0") == 5


def test_gluon_closed_form_is_faster(gluon):
    """Instructions of Newton's steps to one solution over those of the closed form of all, from the
    rows themselves.
    """
    closed, (step, steps) = (
        gluon.number("instructions: closed form"),
        gluon.number("instructions: Newton, a step"),
    )
    assert gluon.number("'analytic is much faster") == pytest.approx(step * steps / closed)
    assert step * steps > 10 * closed


@pytest.mark.parametrize(("name", "count"), [("example", 2), ("random pose", 8)])
def test_gluon_solutions_from_varied_guesses(gluon, name, count):
    """Continuation lists all, certified; each solver meets all from its guesses, and its hits and
    failures are all its guesses.
    """
    assert gluon.number(f"{name}: solutions by continuation").tolist() == [count, count]
    assert (
        f"8 complex solutions, {count} real, {count} certified"
        in gluon.rows(f"{name}: completeness")[0]["computed"]
    )
    for solver in ("rootfinder", "IPOPT"):
        what = f"{name}, {solver}"
        assert gluon.number(f"{what}: modes met").tolist() == [count, 0]
        assert (
            gluon.number(f"{what}: hits per mode").sum()
            + gluon.number(f"{what}: guesses that led to no")
            == 300
        )
    for solver, starts in (("batched", 300), ("newton", 300), ("ipopt", 40)):
        (row,) = gluon.rows(f"{name}, symkin.modes by multistart, {solver}: solutions met")
        assert row["computed"] == [count, 0]
        assert row["run"][0]["starts"] == starts
        assert len(gluon.number(f"{name}, symkin.modes by multistart, {solver}: hits")) == count


def test_gluon_random_poses(gluon):
    """Law: closed form, continuation and multistart list the same solutions at every pose; what
    multistart misses is counted.
    """
    poses, total = gluon.number("random poses, and their solutions")
    assert poses == 20
    assert gluon.number("random poses where closed form = continuation") == 20
    assert gluon.number("random poses, continuation: solutions listed").tolist() == [total, 0]
    listed, missed = gluon.number("random poses, multistart: solutions listed")
    assert listed + missed == total
    assert gluon.number("of the poses with any missed") == 0
    shares = gluon.number("2, 4, 6, 8 real solutions")
    assert shares == pytest.approx([5, 22, 7, 66], abs=3)
    assert shares.sum() == pytest.approx(100)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["continuation", "multistart"])
def test_gluon_inverse_is_that_of_eaik(method):
    """Oracle: EAIK (subproblem decomposition) finds the same solutions on 25 random poses."""
    eaik = pytest.importorskip("eaik.IK_DH")
    arm = symkin.load("gluon_6l3")
    table = arm.dh.rows
    offset = np.array([r.theta for r in table])
    robot = eaik.DhRobot(
        *(np.array([getattr(r, key) for r in table]) for key in ("alpha", "a", "d"))
    )
    rng = np.random.default_rng(25)
    for q in rng.uniform(-180, 180, (25, 6)):
        pose = symkin.solve(arm, joints=q).solution.pose
        answer = robot.IK(np.asarray(pose.matrix))
        exact = [
            np.asarray(v) - offset
            for v, least in zip(answer.Q, answer.is_LS, strict=True)
            if not least
        ]
        options = {"starts": 2000} if method == "multistart" else {}
        modes = symkin.modes(arm, pose=pose, method=method, **options)
        assert modes.method == method
        found = [np.radians(s.actuated_values) for s in modes]
        assert len(found) == len(exact)
        assert all(min(turned(a, b) for b in exact) < 1e-6 for a in found)
        assert all(min(turned(a, b) for b in found) < 1e-6 for a in exact)


def turned(a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference of angles modulo turns, in rad."""
    return float(np.abs((a - b + np.pi) % (2 * np.pi) - np.pi).max())
