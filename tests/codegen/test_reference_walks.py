"""The reference that OK is held against: fine walks in C of its own, judged by formulas; and a
quick campaign.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from helpers import firmware_tools as tools
from helpers import samples
from helpers.gate import in_gate
from helpers.graph_twin import graph_twin
from helpers.inside import Options, build_problem, parse
from helpers.wide_five_bar import COUPLER, HOME, slack_of, tip_of, wide_five_bar
from symkin import load

MACHINES = Path(__file__).parents[2] / "codegen" / "bench" / "machines"
MAPS = Path(__file__).parents[1] / "data" / "maps"


@pytest.fixture(scope="module")
def walker():
    """Walks of any mechanism's direct problem from its reference."""
    tools.compiler("gcc")
    made = tools.bench_module("continuation").Walker

    def walks(mechanism, goals):
        problem = build_problem(mechanism, "direct")
        parts = (problem.system.unknowns, problem.known_coordinates)
        start, begin = (
            np.tile(problem.select_values(problem.closure.reference, p), (len(goals), 1))
            for p in parts
        )
        return problem, made(problem).reached(start, begin, goals)

    return walks


@pytest.mark.parametrize("motion", in_gate(["planar", "spatial"], ["planar"]))
def test_walks_end_where_couplers_part(walker, motion):
    """Lines of cranks by up to half a turn: a walk comes to its end where the couplers meet along
    all of it, and at the circles' tip; else it ends before the first point at which they do not.
    With more rows than unknowns too.
    """
    home = np.array(HOME)
    goals = home + np.pi * np.random.default_rng(3).uniform(-1, 1, (300, 2))
    problem, ends = walker(wide_five_bar(motion), goals)
    slack = slack_of(home, goals, 4000)
    clear = np.abs(slack) > 1e-5
    np.testing.assert_array_equal((ends.shortest > 0)[clear], (slack > 0)[clear])
    reached = problem.join_values(ends.unknowns, home + ends.done[:, None] * (goals - home))
    tips = tip_of(home + ends.done[:, None] * (goals - home))[1]
    place = problem.closure.slices["pose.x"].start
    whole = ends.shortest > 0
    np.testing.assert_allclose(reached[whole, place : place + 2], tips[whole], atol=1e-6 * COUPLER)
    # beside a fold the unknowns go as the root of what is left of the line
    np.testing.assert_allclose(reached[:, place : place + 2], tips, atol=1e-2 * COUPLER)
    stopped = np.flatnonzero((ends.shortest == 0) & clear)
    assert len(stopped) > 20
    for k in stopped:
        short = home + (ends.done[k] - 1e-6) * (goals[k] - home)
        assert slack_of(home, short[None], 4000)[0] > 0
        beyond = home + (ends.done[k] + 1e-4) * (goals[k] - home)
        assert slack_of(home, beyond[None], 4000)[0] < 0


@pytest.mark.parametrize("gap", in_gate([1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2], [1e-7, 1e-2]))
def test_walks_leap_no_gap(walker, gap):
    """Lines on which the couplers part for a moment only, by less than any step of a walk: the
    middle of a line of crank angles has the least slack, -gap.
    """
    home = np.array(HOME)
    direction = np.array([1.0, -1.0]) / math.sqrt(2.0)
    # beside each other: the left crank back, the right one forward; the pins are furthest apart
    # where the cranks lie level
    side = np.linspace(-1.2, 1.2, 41)[:, None] * np.array([1.0, 1.0]) / math.sqrt(2.0)
    goals = home + 1.6 * direction + side
    slack = slack_of(home, goals, 20001)
    low, high = goals[slack > gap], goals[slack < -gap]
    assert len(low)
    assert len(high)
    inner, outer = low[0], high[0]
    for _ in range(200):
        middle = 0.5 * (inner + outer)
        if slack_of(home, middle[None], 20001)[0] < -gap:
            outer = middle
        else:
            inner = middle
    assert slack_of(home, outer[None], 20001)[0] < -0.9 * gap
    _, ends = walker(wide_five_bar("planar"), np.array([outer]))
    assert ends.shortest[0] == 0.0


def test_walks_of_redundant_rods_end_at_the_fold(walker):
    """A delta by pairs of rods, six rows for three unknowns: lines that lead out of the three
    spheres' common points do not end well, others end where the spheres meet, on the side of the
    tips' plane that is below at home.
    """
    d = samples.DELTA
    goals = 3.0 * np.random.default_rng(4).uniform(-1, 1, (200, 3))
    _, ends = walker(samples.delta(), goals)

    def centres(q):
        rows = []
        for k in range(3):
            outward, _ = samples.delta_directions(k)
            arm = d["arm"] * (
                np.cos(q[..., k, None]) * outward - np.sin(q[..., k, None]) * np.array([0, 0, 1.0])
            )
            rows.append((d["base"] - d["platform"]) * outward + arm)
        return np.stack(rows, axis=-2)

    def height(q):
        """Square of the distance of the spheres' common point from the centres' plane, and that
        plane's foot.
        """
        a, b, c = np.moveaxis(centres(q), -2, 0)
        u, v = b - a, c - a
        n = np.cross(u, v)
        nn = np.sum(n * n, axis=-1, keepdims=True)
        foot = np.cross(
            np.sum(u * u, -1, keepdims=True) * v - np.sum(v * v, -1, keepdims=True) * u, n
        ) / (2 * nn)
        return d["rod"] ** 2 - np.sum(foot * foot, axis=-1), a + foot, n / np.sqrt(nn)

    line = np.linspace(0, 1, 4001)[:, None, None] * goals
    least = np.min(height(line)[0], axis=0)
    clear = np.abs(least) > 1.0
    np.testing.assert_array_equal((ends.shortest > 0)[clear], (least > 0)[clear])
    whole = np.flatnonzero(clear & (least > 0))
    assert len(whole) > 50
    assert np.sum(clear & (least < 0)) > 3
    high, foot, normal = (v[whole] for v in height(goals))
    # the side of the centres' plane stays, which is below at home
    below = foot - np.sign(height(np.zeros(3))[2][2]) * normal * np.sqrt(high)[:, None]
    np.testing.assert_allclose(ends.unknowns[whole], below, atol=1e-6 * d["rod"])


def wrist_heights(poses):
    """Of yao2020's tool poses (n, 7) the squares that hold joints 4 and 5 from their folds, by
    where the tool sees the point O in which axes 1, 2, 3 meet: joint 4 takes it a1 about an axis
    105 above the tool's, joint 5 across the tool's axis.
    """
    w, x, y, z = (poses[..., k] for k in range(3, 7))
    across = np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], -1)
    normal = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], -1)
    up, side = (np.sum(v * poses[..., :3], axis=-1) for v in (normal, across))
    fourth = 300.0**2 - (105.0 - up) ** 2
    return fourth, (85.0 + np.sqrt(np.maximum(fourth, 0.0))) ** 2 - side**2


def poses_between(begin, goals, parts):
    """Tool poses (n, 7) at parts (n,) of straight lines, of unit quaternions."""
    poses = begin + parts[:, None] * (goals - begin)
    return np.hstack([poses[:, :3], poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1)[:, None]])


def test_walks_end_short_of_a_fold_and_not_beyond():
    """An arm's tool goes to poses short of the fold of joint 4 by 1e-9 down to 1e-14 of the line,
    and as far beyond: the walk comes to all of the former, by rounding too where joint 5 is beside
    its own fold, and to none of the latter.
    """
    tools.compiler("gcc")
    rng, begin = np.random.default_rng(6), np.array([-545.0, 0.0, 105.0, 1.0, 0.0, 0.0, 0.0])
    goals = np.hstack([rng.uniform(-400, 400, (1000, 3)), rng.normal(size=(1000, 4))])
    goals[:, 3:] /= np.linalg.norm(goals[:, 3:], axis=1)[:, None] * np.sign(goals[:, 3:4])

    def heights(goals, part):
        return wrist_heights(poses_between(begin, goals, np.full(len(goals), part)))

    clear, folds = np.ones(len(goals), bool), np.ones(len(goals))
    for part in np.linspace(0.0, 1.0, 501):
        fourth, fifth = heights(goals, part)
        folds = np.where((folds == 1.0) & (fourth < 0.0), part, folds)
        clear &= (part > folds) | (folds < 1.0) | (fifth > 1.0)
    goals, folds = goals[clear & (folds < 1.0)], folds[clear & (folds < 1.0)]
    assert len(goals) > 100
    low, high = folds - 2e-3, folds
    for _ in range(60):
        middle = 0.5 * (low + high)
        short = wrist_heights(poses_between(begin, goals, middle))[0] > 0.0
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    walk = tools.bench_module("continuation").Walker(build_problem(load("yao2020"), "inverse"))
    before = np.concatenate([np.linspace(0.0, 0.99, 400), 1.0 - np.geomspace(1e-2, 1e-8, 200)])
    for away in (1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14):
        for side in (-1.0, 1.0):
            ends_at = poses_between(begin, goals, low * (1.0 + side * away))
            fourth, fifth = wrist_heights(ends_at)
            clear = (np.sign(fourth) == -side) & (fifth > 1.0)
            for part in before:
                fourth, fifth = heights(ends_at, part)
                clear &= (fourth > 0.0) & (fifth > 1.0)
            assert np.sum(clear) > 50
            tiled = (np.tile(v, (len(goals), 1)) for v in (np.zeros(6), begin))
            ends = walk.reached(*tiled, ends_at)
            np.testing.assert_array_equal(ends.shortest[clear] > 0.0, side < 0.0)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "real"),
    [("five_bar", "double"), ("three_rps", "float"), ("delta", "double")],
)
def test_quick_campaign(name, real):
    """Two legs and one from beside folds, goals over the whole workspace: nothing wrong is OK."""
    tools.compiler("gcc")
    asked = tools.bench_module("asked")
    reach, machine = tools.bench_module("ranges").WIDEST, load(str(MACHINES / f"{name}.toml"))
    found = tools.study(asked.Asked(machine, Options(real)), 400, reach, seed=9, legs=2)
    assert found.said == []
    assert found.ok > 100
    assert found.ok_of_regular > 80


@pytest.mark.slow
def test_given_angles_go_the_nearer_way_round():
    """A guess of a map does not tell whole turns of what is given. Where gears count the turns of
    what is found, the two ways round end at different places. No line begins where its guess does
    not tell where the machine stands.
    """
    tools.compiler("gcc")
    rows, asked = tools.bench_module("rows"), tools.bench_module("asked")
    machine = load(MAPS / "geared_five_bar.toml")
    options = Options("double", given=("left",), find=("le",))
    ranges, rng = tools.bench_module("ranges"), np.random.default_rng(11)
    direct, lines = tools.bench_module("directions").directions(asked.Asked(machine, options))
    found = rows.judged(lines, ranges.by_legs(lines, 40, rng, ranges.WIDEST))
    assert found.said == []
    assert found.ok > 30
    for outcome in ranges.by_legs(direct, 40, rng, ranges.WIDEST):
        assert direct.tells(outcome.starts.guesses, outcome.starts.known).all()


@pytest.mark.slow
def test_a_wrong_ok_is_found(monkeypatch):
    """Answers of code that calls everything OK: the campaign says which are not what the line leads
    to, and how to repeat them.
    """
    tools.compiler("gcc")
    asked = tools.bench_module("asked")
    honest = asked.Asked.answers

    def careless(self, *given):
        found = honest(self, *given)
        return found._replace(status=0 * found.status)

    monkeypatch.setattr(asked.Asked, "answers", careless)
    reach = tools.bench_module("ranges").WIDEST
    found = tools.study(asked.Asked(wide_five_bar("planar")), 50, reach, seed=1)
    assert found.wrong == len(found.said) > 10
    assert "goal [" in found.said[0]
    assert "guess [" in found.said[0]


THREE_TURNS = """
format = 1
name = "three_turns"
angle_unit = "deg"
length_unit = "mm"
[dh]
convention = "standard"
rows = [{ type = "R", theta = 0.0, d = 0.0, a = 100.0, alpha = -90.0 },
    { type = "R", theta = 0.0, d = 100.0, a = 55.5, alpha = 45.0 },
    { type = "R", theta = 90.0, d = 0.0, a = 0.0, alpha = 180.0 }]
"""


def tool_of(joints):
    """The frames (n, 4, 4) of the tool of `THREE_TURNS`, as products of its rows' matrices."""
    frames = np.eye(4)
    for q, (theta, d, a, alpha) in zip(
        joints.T,
        [(0, 0, 100, -np.pi / 2), (0, 100, 55.5, np.pi / 4), (np.pi / 2, 0, 0, np.pi)],
        strict=True,
    ):
        c, s, ca, sa = np.cos(theta + q), np.sin(theta + q), math.cos(alpha), math.sin(alpha)
        none, one = 0 * q, 1 + 0 * q
        rows = [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s]]
        rows += [[none, sa * one, ca * one, d * one], [none, none, none, one]]
        frames = frames @ np.moveaxis(np.array(rows), -1, 0)
    return frames


@pytest.mark.slow
@pytest.mark.parametrize("real", ["float", "double"])
@pytest.mark.parametrize("joint", ["w.x[0]", "-w.x[0]", "w.x[0] + 1e-5f"])
def test_an_arm_of_few_joints_is_judged_by_where_its_tool_is(real, joint):
    """Its rounded poses are none that it can take, and lines between poses leave them: what is OK
    is right where the rows' matrices, multiplied, put the tool at the goal, and wrong where the
    generated C has another sign, or is off by 1e-5.
    """
    tools.compiler("gcc")
    asked = tools.bench_module("asked").Asked(parse(THREE_TURNS, "three.toml"), Options(real))
    stored = "joints[0] = w.x[0];"
    assert asked.program.source.count(stored) == 1
    source = asked.program.source.replace(stored, f"joints[0] = {joint};")
    vars(asked)["program"] = replace(asked.program, source=source)
    ranges, rows = tools.bench_module("ranges"), tools.bench_module("rows")
    (lines,) = tools.bench_module("directions").directions(asked)
    seen = {"ok": 0, "wrong": 0}
    for outcomes in (
        ranges.paths(lines, 5, np.random.default_rng(3), 40),
        ranges.by_legs(lines, 20, np.random.default_rng(3), ranges.SMALL),
    ):
        for outcome in outcomes:
            found = tool_of(outcome.answers.found)[:, :3, 3]
            off = np.max(np.abs(found - outcome.goals[:, :3]), axis=1) / lines.size
            row = rows.judged(lines, [outcome])
            assert row.wrong >= np.sum(outcome.ok & (off > 3e-6))
            seen["ok"], seen["wrong"] = seen["ok"] + row.ok, seen["wrong"] + row.wrong
    assert seen["ok"] > 50
    assert seen["wrong"] == (0 if joint == "w.x[0]" else seen["ok"])


def test_a_campaign_goes_on_where_it_was_interrupted(monkeypatch, tmp_path, capsys):
    """What the file holds is not asked again, what it lacks is; the table is that of one run."""
    branches, kept, asked = tools.bench_module("branches"), tmp_path / "kept.jsonl", []

    def rows(machine, word, chosen):
        asked.append((machine.options.real, word))
        return [("formulas", branches.Row(goals=chosen.count, ok=2))]

    def table():
        assert branches.main() == 0
        return capsys.readouterr().out.partition("| machine")[2]

    words = ["five_bar", "--range", "paths", "grazes", "--count", "3", "--keep", str(kept)]
    monkeypatch.setattr("sys.argv", ["branches.py", *words])
    monkeypatch.setattr(branches, "_rows", rows)
    whole, lines = table(), kept.read_text().splitlines()
    assert len(asked) == len(lines) == 4
    kept.write_text("\n".join([*lines[:3], lines[3][:-20]]))  # the last line was not ended
    assert table() == whole
    assert asked[4:] == [asked[3]]


@pytest.mark.slow
def test_answers_of_a_graph_with_a_platform_are_held_against_its_rows():
    """As those of limbs: poses it can take are taken, joints of them are found."""
    tools.compiler("gcc")
    closes, asked = tools.bench_module("closes"), tools.bench_module("asked")
    machine = asked.Asked(graph_twin(samples.readme_five_bar("planar")))
    found = closes.closes(machine, 6, np.random.default_rng(3))
    assert found.taken == found.feasible > 0
    assert found.said == []
