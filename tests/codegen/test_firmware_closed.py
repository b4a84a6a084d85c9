"""Generated closed forms of arms: all branches are the modes of Python, named and nearest ones are
among them, the rest is refused.
"""

from __future__ import annotations

import re
import subprocess
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.arms import direction, free, random_values, serial, short_structures, structures
from helpers.gate import in_gate
from helpers.inside import Options, build_program, codegen_folder, plan_of, write_folder
from helpers.samples import pieper

ARMS = structures(np.random.default_rng(3)) | short_structures(np.random.default_rng(3))
ARMS |= {
    "gluon_6l3": symkin.load("gluon_6l3"),
    "yao2020": symkin.load("yao2020"),
    "pieper": pieper(),
}
IN_GATE = (
    "parallel_inner",
    "wrist_first",
    "planar_with_slide",
    "gluon_6l3",
    "yao2020",
)
"""One arm of each kind of structure."""
POSES = 20

MAIN = """
#include "@.h"
#include <stdio.h>
int main(void)
{
    @_pose pose; double v[7]; double g[$];
    while (scanf("%lf %lf %lf %lf %lf %lf %lf", v, v+1, v+2, v+3, v+4, v+5, v+6) == 7) {
        @_real all[^_BRANCHES][$]; @_real guess[$]; @_real near[$];
        for (int i = 0; i < $; ++i) { if (scanf("%lf", g + i) != 1) { return 1;
          } guess[i] = (@_real)g[i]; near[i] = 0; }
        for (int i = 0; i < 3; ++i) { pose.position[i] = (@_real)v[i]; }
        for (int i = 0; i < 4; ++i) { pose.quaternion[i] = (@_real)v[3 + i]; }
        const int count = @_inverse_all(&pose, all);
        const int status = (int)@_inverse_nearest(&pose, guess, near);
        (void)printf("%d %d", count, status);
        for (int i = 0; i < $; ++i) { (void)printf(" %.17g", (double)near[i]); }
        for (int k = 0; k < count; ++k) { for (int i = 0; i < $; ++i) {
          (void)printf(" %.17g", (double)all[k][i]); } }
        (void)printf("\\n");
    }
    return 0;
}
"""


def answers(
    arm: symkin.Mechanism,
    folder,
    real: str,
    rows: list[list[float]],
    *flags: str,
    write=tools.write_code,
) -> list[tuple[np.ndarray, int, np.ndarray]]:
    """Of rows of a pose and a guess: all branches, the status of the nearest one, and that one."""
    write(arm, folder, Options(real))
    n = len(arm.actuated)
    main = MAIN.replace("@", arm.name).replace("^", arm.name.upper()).replace("$", str(n))
    (folder / "all.c").write_text(main)
    program = tools.built("gcc", folder, [f"{arm.name}.c", "all.c"], "all", "-O1", *flags)
    text = "\n".join(" ".join(repr(float(v)) for v in row) for row in rows)
    done = subprocess.run([str(program)], input=text, capture_output=True, text=True, check=True)
    found = []
    for line in done.stdout.splitlines():
        numbers = [float(v) for v in line.split()]
        found.append(
            (
                np.array(numbers[2 + n :]).reshape(-1, n),
                int(numbers[1]),
                np.array(numbers[2 : 2 + n]),
            )
        )
    return found


def in_radians(arm: symkin.Mechanism, values) -> np.ndarray:
    return np.array(
        [arm.angle_in(v) if c.is_angular else v for c, v in zip(arm.actuated, values, strict=True)]
    )


def apart(arm: symkin.Mechanism, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Largest differences of joint values, whole turns left aside, lengths over the size."""
    angular = np.array([c.is_angular for c in arm.actuated])
    gap = np.asarray(a) - np.asarray(b)
    return np.max(
        np.abs(np.where(angular, np.angle(np.exp(1j * gap)), gap / arm.characteristic_length)),
        axis=-1,
    )


def cases(arm: symkin.Mechanism, count: int) -> tuple[list[symkin.Pose], list[list[float]]]:
    """Poses of random joints, and rows of each with those joints, moved a little, as the guess."""
    rng, poses, rows = np.random.default_rng(8), [], []
    for _ in range(count):
        q = np.array(random_values(arm, rng))
        values = [
            arm.angle_out(v) if c.is_angular else v for c, v in zip(arm.actuated, q, strict=True)
        ]
        pose = symkin.solve(arm, joints=values).solution.pose
        poses.append(pose)
        rows.append([*pose.position, *pose.quaternion, *(q + 0.01 * rng.uniform(-1, 1, len(q)))])
    return poses, rows


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(ARMS, ["planar_with_slide"]))
def test_all_branches_are_the_modes_of_python(name, tmp_path):
    """As many, and the same joint values; the nearest to the guess is the arm's own; in double and
    at well conditioned poses.
    """
    arm = ARMS[name]
    poses, rows = cases(arm, POSES)
    expected = symkin.modes(arm, pose=poses)
    compared = 0
    for modes, row, (branches, status, near) in zip(
        expected, rows, answers(arm, tmp_path, "double", rows), strict=True
    ):
        if modes.method != "closed" or max(mode.condition for mode in modes) > 1e3:
            continue
        compared += 1
        ours = np.array([in_radians(arm, mode.actuated) for mode in modes])
        assert len(branches) == len(ours)
        assert max(apart(arm, branches, one).min() for one in ours) < 1e-9
        assert status == 0
        assert apart(arm, ours, near).min() < 1e-9
        assert (
            np.max(np.abs(near - row[7:])[[c.is_angular for c in arm.actuated]], initial=0.0)
            < np.pi + 1e-9
        )
    assert compared > POSES // 2


def test_a_part_of_a_line_declares_what_it_reads():
    """The last step of a gantry declared the root that its slides leave, which nothing read: C with
    warnings as errors was refused.
    """
    source = build_program(ARMS["gantry_without_wrist"], Options("double")).source
    (body,) = re.findall(r"_inverse_keeps\([^)]*\)\n\{\n(.*?)\n\}\n", source, re.DOTALL)
    declared = re.findall(r"const \S+ (\w+) = ", body)
    assert "whole3" in declared
    assert [name for name in declared if len(re.findall(rf"\b{name}\b", body)) < 2] == []


@pytest.mark.long
def test_the_nearest_branch_is_that_of_the_guess(tmp_path):
    """A guess a hundredth beside the arm's joints names their branch, in float too."""
    arm = ARMS["gluon_6l3"]
    _, rows = cases(arm, POSES)
    found = answers(arm, tmp_path, "float", rows)
    gaps = np.array(
        [
            apart(arm, near, row[7:])
            for row, (_, status, near) in zip(rows, found, strict=True)
            if status == 0
        ]
    )
    assert len(gaps) > 0.9 * POSES
    assert np.mean(gaps < 0.02) > 0.9
    assert all(len(branches) % 2 == 0 for branches, _, _ in found)


@pytest.mark.long
def test_poses_out_of_reach_have_no_branch_under_sanitizers(tmp_path):
    """Far poses, a wrist in line, and quaternions of other lengths: no branch, a status, nothing
    undefined.
    """
    arm = replace(pieper(), name="reach")
    straight = symkin.solve(arm, joints=[0.3, 0.4, 0.5, 0.6, 0.0, 0.8]).solution.pose
    guess = [0.1] * 6
    rows = [
        [1e3, 0, 0, 1, 0, 0, 0, *guess],
        [1e30, -1e30, 1e30, 1, 0, 0, 0, *guess],
        [*straight.position, *straight.quaternion, *guess],
        [0, 0, 100, 2, 0, 0, 0, *guess],
        [float("nan"), 0, 100, 1, 0, 0, 0, *guess],
        [0, 0, 100, float("inf"), 0, 0, 0, *guess],
        [0, 0, 100, 1, 0, 0, 0, float("nan"), *guess[1:]],
    ]
    found = answers(
        arm,
        tmp_path,
        "float",
        rows,
        "-fsanitize=address,undefined,float-divide-by-zero,float-cast-overflow",
    )
    statuses = [status for _, status, _ in found]
    ok, singular, nonfinite, out_of_range = 0, 2, 3, 4
    assert statuses[0] == statuses[1] == statuses[3] == out_of_range
    assert statuses[2] == singular
    assert statuses[4] == statuses[5] == statuses[6] == nonfinite
    assert all(not len(found[k][0]) for k in (0, 1, 3, 4, 5))
    assert all(np.all(near == 0.0) for _, status, near in found if status != ok)


def test_only_branches_within_the_limits_are_listed(tmp_path):
    """Limits leave out branches, and turn angles into them where a whole turn does."""
    arm = pieper()
    (limb,) = arm.limbs
    ranges = [(0.0, 7.0), (-3.0, 3.0), (-3.2, 0.0), None, None, None]
    joints = [replace(joint, limits=span) for joint, span in zip(limb.joints, ranges, strict=True)]
    limited = replace(arm, name="limited", limbs=[replace(limb, joints=joints)])
    poses, rows = cases(arm, 10)
    inside = symkin.modes(limited, pose=poses)
    for modes, (branches, _, _) in zip(
        inside, answers(limited, tmp_path, "double", rows), strict=True
    ):
        assert len(branches) == sum(bool(mode.within_limits) for mode in modes)
        for values in branches:
            assert all(
                span is None or span[0] <= v <= span[1]
                for v, span in zip(values, ranges, strict=True)
            )


def test_a_calibrated_arm_keeps_its_branches(tmp_path):
    """Axes that are off by a thousandth have no closed form of their own: the ideal arm's begins
    Newton's method, which ends at this arm's pose; the folder's own test passes too.
    """
    rng = np.random.default_rng(2)
    (limb,) = pieper().limbs
    joints = [
        replace(
            j,
            point=np.array(j.point) + 0.1 * rng.normal(size=3),
            axis=np.array(j.axis) + 1e-3 * direction(rng),
        )
        for j in limb.joints
    ]
    arm = replace(pieper(), name="calibrated", limbs=[replace(limb, joints=joints)])
    assert plan_of(arm) is None
    poses, rows = cases(arm, 10)
    counts = []
    for pose, (branches, status, near) in zip(
        poses, answers(arm, tmp_path, "double", rows, write=write_folder), strict=True
    ):
        counts.append(len(branches))
        for values in [*branches, *([near] if status == 0 else [])]:
            again = symkin.solve(arm, joints=values.tolist()).solution.pose
            assert np.abs(again.position - pose.position).max() < 1e-8 * arm.characteristic_length
            assert 1 - abs(again.quaternion @ pose.quaternion) < 1e-12
    assert np.mean(counts) > 4


def test_what_a_folder_says_of_its_closed_form():
    """Steps in README and manifest, names in the header."""
    folder = tools.folder("gluon_6l3_double")
    steps, said = tools.manifest("gluon_6l3_double")["closed_form"], folder / "README.md"
    assert steps["choices"] == ["shoulder", "wrist", "elbow"]
    assert all(line in said.read_text() for line in steps["steps"])
    assert "#define GLUON_6L3_ELBOW (1U)" in (folder / "gluon_6l3.h").read_text()


@pytest.mark.parametrize("kind", ["struct", pytest.param("general", marks=pytest.mark.long)])
def test_a_folder_without_a_closed_form_says_so(kind):
    """A geometry given at run time, and an arm of general shape."""
    arm, options = symkin.load("gluon_6l3"), Options(geometry="struct")
    if kind == "general":
        rng = np.random.default_rng(0)
        arm, options = serial("general", [free(rng) for _ in range(6)], rng), Options()
    program = build_program(arm, options)
    assert "None was found" in codegen_folder.readme(program)
    assert "inverse_all" not in program.header
