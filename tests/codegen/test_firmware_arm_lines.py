"""Lines of tool poses that the closed form of generated arms calls OK, followed finely by the walks
of codegen/bench.
"""

from __future__ import annotations

import math
import re
import subprocess
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.arms import structures
from helpers.gate import in_gate
from helpers.inside import Options, build_program, readme_of
from helpers.samples import random_mechanism

GUESS = """
#include "scara.h"
#include <stdio.h>
int main(void)
{
    const double inside[4] = { 0.3, 2.4, 0.0, -50.0 };
    const double beyond[4] = { 0.3, 2.5, 0.0, -50.0 };
    double joints[4];
    scara_pose pose;
    scara_info info;
    (void)scara_direct(inside, &pose);
    const int from_beyond = (int)scara_inverse(0, &pose, beyond, joints, &info);
    (void)printf("%d %d ", from_beyond, info.joint);
    const int from_inside = (int)scara_inverse(0, &pose, inside, joints, &info);
    (void)printf("%d %d ", from_inside, info.joint);
    (void)printf("%d", (int)scara_inverse_nearest(&pose, beyond, joints));
    return 0;
}
"""


POINTS = 200
"""Points of a line at which limits are looked at."""


def limited(name: str, seed: int = 5) -> symkin.Mechanism:
    """An arm of this structure whose joints have limits of different widths, half a turn to more
    than a whole one.
    """
    rng, arm = np.random.default_rng(seed), structures(np.random.default_rng(3))[name]
    joints = []
    for joint in arm.limbs[0].joints:
        half = rng.uniform(0.5, 3.5) if joint.type == "R" else 0.3 * arm.characteristic_length
        middle = rng.uniform(-0.5, 0.5) * half
        span = middle - half, middle + half
        joints.append(
            replace(
                joint, limits=tuple(arm.angle_out(v) for v in span) if joint.type == "R" else span
            )
        )
    return replace(arm, limbs=(replace(arm.limbs[0], joints=tuple(joints)),))


def walked(arm: symkin.Mechanism, count: int, reach: float, real: str = "double") -> dict[str, int]:
    """Counts of lines: all, OK, regular ones that keep off limits by a hundredth of the range, OK
    of these, and those that leave limits. Fails where what is OK leaves limits (but for the room of
    16 roundings), or is not where the line leads.
    """
    tools.compiler("gcc")
    asked, directions = tools.bench_module("asked"), tools.bench_module("directions")
    lines = directions.directions(asked.Asked(arm, Options(real)), longest=1.0)[0]
    rng, joints, size = np.random.default_rng(1), arm.actuated, arm.characteristic_length
    units = np.array([1.0 if c.is_angular else size / 3 for c in joints])
    free = [c.limits or (-math.pi * u, math.pi * u) for c, u in zip(joints, units, strict=True)]
    (low, high), limited = np.array(free).T, np.array([c.limits is not None for c in joints])
    guesses = lines.asked.rounded(rng.uniform(low, high, (count, len(joints))))
    moves = reach * units * rng.uniform(-1.0, 1.0, guesses.shape)
    ends = lines.asked.rounded(np.clip(guesses + moves, low, high))
    known, goals = (np.array([lines.kind.forward_at(q) for q in part]) for part in (guesses, ends))
    goals = lines.asked.rounded(goals)
    answers = lines.answers(goals, guesses)
    begin, end = lines.line(known, goals)
    at, whole, spare = guesses, np.ones(count, bool), np.ones(count)
    for k in range(POINTS):
        parts = [begin + p / POINTS * (end - begin) for p in (k, k + 1)]
        for part in parts:
            part[:, 3:] /= np.linalg.norm(part[:, 3:], axis=1, keepdims=True)
        walked = lines.walker.reached(at, *parts)
        whole &= walked.shortest > 0.0
        at = np.where(whole[:, None], walked.unknowns, at)
        share = (at - low) / (high - low)
        near = np.where(limited, np.minimum(share, 1.0 - share), 1.0)
        spare = np.minimum(spare, near.min(axis=1))
    ok = answers.status == 0
    right = whole & (spare > (-1e-5 if real == "float" else -1e-8))
    right &= np.max(np.abs(at - answers.found) / units, axis=1) < 1e-2
    assert np.all(right[ok]), (guesses[ok & ~right][:2].tolist(), goals[ok & ~right][:2].tolist())
    regular = whole & (spare > 0.01)
    counts = (np.ones(count), ok, regular, ok & regular, whole & (spare < 0.0))
    names = ("lines", "ok", "regular", "answered", "outside")
    return {name: int(np.sum(c)) for name, c in zip(names, counts, strict=True)}


ANSWERED = {("parallel_inner_mirrored", 1.0): 0.5, ("parallel_inner_mirrored", 3.1): 0.15}
"""Share of regular lines that are answered at least, where it is small: this arm begins from its
far end, where turns of the tool move what a part bounds by the whole reach, and lines need more
parts than the usual 100. Of 153 regular ones 27 are answered, with 255 parts 92.
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    in_gate(
        ["ur5e", "scara", *list(structures(np.random.default_rng(3)))[:3]],
        ["ur5e"],
    ),
)
@pytest.mark.parametrize("reach", in_gate([0.2, 1.0, 3.1], [1.0]))
def test_lines_that_are_ok_have_their_branch_everywhere(name, reach):
    """Each point of a line has the guess's branch, and its joints end at the answer,
    whole turns included; and most regular lines are answered.
    """
    made = structures(np.random.default_rng(3))
    found = walked(made.get(name) or symkin.load(name), 1500, reach)
    assert found["answered"] > ANSWERED.get((name, reach), 0.65) * found["regular"]


TWO_FOLDS = [
    (
        [18.86388663048635, 455.8541007333297, 87.05871498063338]
        + [0.6052428210394809, 0.5235028757225149, 0.2159829222712809, 0.5594436915164797],
        [0.70889, 0.018124, 0.76199, -0.670662, 0.171769, -13.710721362585193],
    ),
    (
        [-220.60928091269312, -178.7192738895519, 423.72158800086163]
        + [0.5089900756907517, 0.3408496816441135, -0.5573922706788773, -0.5604145376048647],
        [-0.42354881667541155, -0.4754737169804036, 2.008963446387515]
        + [1.0990220568042088, -0.15547934675913772, 721.0763315930262],
    ),
    (
        [-105.04052745572707, -561.0232578855695, -44.628856161438186]
        + [0.25350444597255223, -0.721841489444747, -0.3290017930409211, 0.5535685866847914],
        [3.3859984974967325, 1.0809308061750649, 1.6181638288388187]
        + [-0.24485032235949744, 0.42012041834972386, -257.7142171028499],
    ),
]
"""Goals and guesses of yao2020, in mm and rad."""


def test_a_line_beside_the_folds_of_two_joints_is_refused() -> None:
    """The second square falls below zero and rises again while a joint that it reads turns fast
    beside its own fold; no configuration is there, as a fine walk says.
    """
    tools.compiler("gcc")
    asked, directions = tools.bench_module("asked"), tools.bench_module("directions")
    (lines,) = directions.directions(asked.Asked(symkin.load("yao2020"), Options("double")))
    goals, guesses = (np.array(part) for part in zip(*TWO_FOLDS, strict=True))
    known = np.array([lines.kind.forward_at(q) for q in guesses])
    walked = lines.walker.reached(guesses, *lines.line(known, goals))
    assert np.all(walked.shortest <= 0.0)
    assert np.all(lines.answers(goals, guesses).status != 0)


MARGINS = """
#include "NAME.c"
#include <stdio.h>
#include <stdlib.h>
int main(void)
{
    double largest[64] = { 0.0 };
    for (int k = 0; k < 20000; ++k) {
        double joints[COUNT], pose[7];
        NAME_inverse_work work;
        for (int i = 0; i < COUNT; ++i) {
            joints[i] = 6.3 * rand() / RAND_MAX;
        }
        NAME_inverse_begin(&work, joints, pose);
        for (size_t i = 0; i < sizeof work.left / sizeof work.left[0]; ++i) {
            largest[i] = (work.left[i] > largest[i]) ? work.left[i] : largest[i];
        }
    }
    for (int i = 0; i < 64; ++i) {
        (void)printf("%.9g ", largest[i]);
    }
    return 0;
}
"""


@pytest.mark.parametrize("name", in_gate(["ur5e", "gluon_6l3", "yao2020"], ["ur5e"]))
def test_the_size_that_is_told_of_a_guard_bounds_it(name, tmp_path):
    """The values of an arm's squares at random joints are no larger than the README's sizes, which
    are no more than half as large again.
    """
    arm = symkin.load(name)
    tools.write_code(arm, tmp_path, Options("double"))
    told = readme_of(build_program(arm, Options("double")))
    assert "NAME_" not in told
    rows = re.findall(r"\| ([\d.e+-]+) \| proved \|", told)
    sizes = np.array([float(row) for row in rows])
    code = MARGINS.replace("NAME", arm.name).replace("COUNT", str(len(arm.actuated)))
    (tmp_path / "margins.c").write_text(code)
    run = [tools.compiler("gcc"), "-O1", "-w", str(tmp_path / "margins.c"), "-lm"]
    subprocess.run([*run, "-o", str(tmp_path / "margins")], check=True)
    done = subprocess.run([str(tmp_path / "margins")], capture_output=True, text=True, check=True)
    largest = np.array([float(word) for word in done.stdout.split()])
    assert np.all(largest[: len(sizes)] <= 1.005 * sizes)
    assert np.all(sizes <= 1.5 * largest[: len(sizes)])
    assert not np.any(largest[len(sizes) :])


BOUNDS = r"""
#include "NAME.c"
#include <stdio.h>
#include <stdlib.h>
#define POINTS 100
static const double unit[COUNT] = { UNITS };
static const int read[COUNT] = { READ };
static double drawn(double half) { return half * (2.0 * rand() / RAND_MAX - 1.0); }
static double over(double number, double bound, double least)
{
    return (number > least) ? number / bound : 0.0;
}
int main(void)
{
    static const double near[16] = { 0.0 };
    double speed = 0.0, change = 0.0, away = 0.0;
    int parts = 0, lost = 0;
    for (int k = 0; k < 2000; ++k) {
        double guess[COUNT], goal[COUNT], from[7], to[7], u[2 * COUNT], way2[2] = { 0.0, 0.0 };
        double last[COUNT], before[COUNT];
        const double reach = exp(drawn(2.5) - 2.5);
        NAME_inverse_work work, *w = &work;
        for (int i = 0; i < COUNT; ++i) {
            guess[i] = unit[i] * drawn(3.1);
            goal[i] = guess[i] + unit[i] * drawn(reach);
            last[i] = before[i] = guess[i];
        }
        NAME_half_turns(goal, u);
        NAME_pose_of_turns(u, to);
        unsigned int wanted = 0U;
        NAME_inverse_begin(w, guess, from);
        for (size_t i = 0; i < sizeof work.sign / sizeof work.sign[0]; ++i) {
            wanted |= ((w->sign[i] < 0.0) ? 2U : 1U) << (2U * i);
        }
        double cosine = 0.0;
        for (int i = 3; i < 7; ++i) {
            cosine += from[i] * to[i];
        }
        for (int i = 0; i < 7; ++i) {
            to[i] *= ((i > 2) && (cosine < 0.0)) ? -1.0 : 1.0;
            way2[0] += (i < 3) ? pow((to[i] - from[i]) / SIZE, 2) : 0.0;
        }
        way2[1] = 16.0 * (1.0 - fabs(cosine)) / (1.0 + fabs(cosine));
        if ((NAME_inverse_aim(w, to) != 0) || !NAME_inverse_keeps(w, way2)) {
            continue;
        }
        ++parts;
        for (int s = 1; s <= POINTS; ++s) {
            double x[7], found[1][COUNT], margin[16], length = 0.0;
            bool undecided = false;
            for (int i = 0; i < 7; ++i) {
                x[i] = from[i] + (double)s / POINTS * (to[i] - from[i]);
                length += (i > 2) ? x[i] * x[i] : 0.0;
            }
            for (int i = 3; i < 7; ++i) {
                x[i] /= sqrt(length);
            }
            lost += NAME_branches(x, near, wanted, found, &undecided, margin) != 1;
            for (int i = 0; i < COUNT; ++i) {
                const double per = POINTS / ((unit[i] == 1.0) ? 1.0 : SIZE);
                double way = found[0][i] - last[i];
                way = (unit[i] == 1.0) ? remainder(way, 6.283185307179586) : way;
                if (read[i]) {
                    const double bend = fabs(way - (last[i] - before[i])) * per * POINTS;
                    speed = fmax(speed, over(fabs(way) * per, w->speed[i], 1e-6));
                    change = fmax(change, over((s > 1) ? bend : 0.0, w->change[i], 1e-4));
                }
                before[i] = last[i];
                last[i] += way;
            }
        }
        for (int i = 0; i < COUNT; ++i) {
            const double end = NAME_inverse_joint(i, w->aimed[i], w->found[i]);
            const double size = (unit[i] == 1.0) ? 1.0 : SIZE;
            away = fmax(away, fabs(last[i] - end));
            away = fmax(away, fabs(w->found[i] - end) - 7e-5 * size * w->way[i]);
        }
    }
    (void)printf("%d %d %.6g %.6g %.6g", parts, lost, speed, change, away);
    return 0;
}
"""


@pytest.mark.parametrize(
    "name",
    in_gate(["ur5e", "yao2020", "scara", *structures(np.random.default_rng(3))], ["yao2020"]),
)
def test_joints_go_no_faster_than_is_proved(name, tmp_path):
    """On parts of lines that are kept speeds of joints and the changes of these are within the
    bounds that later steps read, which nearly reach them; each point has the branch, and ways are
    told with whole turns.
    """
    arm = structures(np.random.default_rng(3)).get(name) or symkin.load(name)
    tools.write_code(arm, tmp_path, Options("double"))
    text = (tmp_path / f"{arm.name}.c").read_text()
    told = (rf"_inverse_bounds\(w, {i},|w->change\[{i}\] = " for i in range(len(arm.actuated)))
    read = [re.search(words, text) is not None for words in told]
    size = arm.characteristic_length
    units = ["1.0" if c.is_angular else f"{0.1 * size!r}" for c in arm.actuated]
    words = {"UNITS": ", ".join(units), "READ": ", ".join(str(int(r)) for r in read)}
    words |= {"COUNT": str(len(units)), "SIZE": repr(size), "NAME": arm.name}
    code = BOUNDS
    for word, value in words.items():
        code = code.replace(word, value)
    (tmp_path / "bounds.c").write_text(code)
    run = [tools.compiler("gcc"), "-O1", "-w", str(tmp_path / "bounds.c"), "-lm"]
    subprocess.run([*run, "-o", str(tmp_path / "bounds")], check=True)
    done = subprocess.run([str(tmp_path / "bounds")], capture_output=True, text=True, check=True)
    parts, lost, speed, change, away = (float(word) for word in done.stdout.split())
    assert parts > 10
    assert lost == 0
    assert 0.5 < speed < 1.001
    assert change < 1.001
    assert away < 1e-9


@pytest.mark.parametrize("real", in_gate(["double", "float"], ["double"]))
def test_the_scara_keeps_its_limits_along_lines(real):
    """No OK where a point is outside, nearly all OK where all are inside by a hundredth
    of the range.
    """
    found = walked(symkin.load("scara"), 600, 1.0, real)
    assert found["outside"] > 0.02 * found["lines"]
    assert found["answered"] >= 0.95 * found["regular"] > 0.3 * found["lines"]


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", ["parallel_inner", "wrist_parallel_two_three", "stanford"])
def test_arms_keep_their_limits_along_lines(name):
    """The same of arms of six joints, limits more than a whole turn wide and slides among them;
    lines that are free of limits are as often OK as those of the arm without limits.
    """
    free = walked(structures(np.random.default_rng(3))[name], 400, 0.3)
    found = walked(limited(name), 400, 0.3)
    assert found["outside"] > 0.02 * found["lines"]
    assert found["answered"] / found["regular"] >= free["answered"] / free["regular"] - 0.05


@pytest.mark.parametrize("name", in_gate(["ur5e", "gluon_6l3", "yao2020", "scara"], ["ur5e"]))
@pytest.mark.parametrize("real", ["double", "float"])
def test_an_answer_is_one_from_itself(name, real):
    """Of joints all over their ranges: the scalar product of two unit quaternions that are one
    may be above 1.
    """
    tools.compiler("gcc")
    asked, directions = tools.bench_module("asked"), tools.bench_module("directions")
    arm = symkin.load(name)
    lines, rng = directions.directions(asked.Asked(arm, Options(real)))[0], np.random.default_rng(2)
    low, high = np.array([c.limits or (-math.pi, math.pi) for c in arm.actuated]).T
    guesses = lines.asked.rounded(rng.uniform(low, high, (3000, len(low))))
    goals = lines.asked.rounded(np.array([lines.kind.forward_at(q) for q in guesses]))
    first = lines.answers(goals, guesses)
    ok = first.status == 0
    assert np.mean(ok) > 0.9
    assert np.all(lines.answers(goals[ok], first.found[ok]).status == 0)


def test_a_guess_outside_its_limits_begins_no_line(tmp_path):
    """The joint is named; the pose itself is within reach, as the formulas that look at no line
    say.
    """
    arm = symkin.load("scara")
    tools.write_code(arm, tmp_path, Options("double"))
    (tmp_path / "main.c").write_text(GUESS)
    program = tools.built("gcc", tmp_path, ["scara.c", "main.c"], "main")
    assert tools.passed(program).split() == ["4", "1", "0", "4", "0"]


def six_oblique_joints() -> symkin.Mechanism:
    """An arm without a closed form, which Newton's method solves."""
    drawn = random_mechanism(np.random.default_rng(4), ["rrrrrr"], serial=True)
    joints = [replace(joint, limits=(-1.5, 1.5)) for joint in drawn.limbs[0].joints]
    return replace(drawn, limbs=[replace(drawn.limbs[0], joints=joints)])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arm", "real"), [(lambda: symkin.load("scara"), "double"), (six_oblique_joints, "float")]
)
def test_an_answer_at_a_limit_stands_still(arm, real):
    """A joint at its limit, or beyond by less than the room for rounding: what is OK is OK from
    itself.
    """
    tools.compiler("gcc")
    asked = tools.bench_module("asked").Asked(arm(), Options(real))
    low, high = np.array([c.limits or (-3.0, 3.0) for c in asked.mechanism.actuated]).T
    rng, count = np.random.default_rng(3), 400
    joints = rng.uniform(low, high, (count, len(low)))
    rows, at = np.arange(count), rng.integers(len(low), size=count)
    joints[rows, at] = high[at] + rng.choice([0.0, 1e-10, 9e-10, 1e-9], count)
    poses = np.array([asked.program.kind.forward_at(row) for row in joints])
    found = asked.answers(poses, joints - 0.02 * rng.uniform(0.0, 1.0, joints.shape))
    ok = found.status == 0
    assert np.sum(ok) > 100
    assert not asked.answers(poses[ok], found.found[ok]).status.any()
