"""Near misses: what a path misses is not said to be met, and the summary says how near it came."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import symkin
from helpers.samples import four_bar, three_rrr, turning
from symkin import Joint, Limb, Mechanism, track

Z = (0.0, 0.0, 1.0)


def parallelogram(gap: float) -> Mechanism:
    """Bases 100 apart, crank and rocker 40, the coupler 100 and a gap; it is flat where the crank
    lies along the bases.
    """
    angle, coupler = math.radians(60), 100.0 + gap
    b = 40.0 * np.array([math.cos(angle), math.sin(angle)])
    away = np.array([100.0, 0.0]) - b
    r = float(np.linalg.norm(away))
    along = (r * r + coupler**2 - 1600.0) / (2 * r)
    u = away / r
    c = b + along * u - math.sqrt(coupler**2 - along**2) * np.array([u[1], -u[0]])
    crank = Joint("crank", "R", (0.0, 0.0, 0.0), Z, actuated=True, zero=angle)
    limbs = [
        Limb("left", [crank, turning("b", *b)]),
        Limb("right", [turning("d", 100.0, 0.0), turning("c", *c)]),
    ]
    return Mechanism("parallelogram", limbs, motion="planar", platform_position=(b[0], b[1], 0.0))


@pytest.mark.slow
@pytest.mark.parametrize("gap", [1e-9, 1e-10, 1e-11, 1e-12, -1e-12, -1e-11, -1e-10])
def test_a_near_miss_is_no_bifurcation(gap: float) -> None:
    """Beside the fold of a parallelogram by 1e-9 to 1e-12 of a millimetre: folded, passed or
    unproved, but no branches meet.
    """
    found = track(parallelogram(gap), joints=[[1.0], [-1.0]], name_modes=False)
    kind = None if found.stop is None else found.stop.kind
    assert kind in (("turning point", "unproved") if gap > 0 else (None, "unproved"))
    if kind == "unproved":
        assert "a singularity is very near" in found.statement
        assert not found.certified
    assert found.nearest is not None
    assert found.nearest.smallest_singular_value < 1e-5


def test_branches_that_meet_are_a_bifurcation() -> None:
    found = track(parallelogram(0.0), joints=[[1.0], [-1.0]], name_modes=False)
    assert found.stop is not None
    assert found.stop.kind == "bifurcation"


@pytest.mark.slow
@pytest.mark.parametrize("gap", [-1e-6, -1e-3, -0.1])
def test_the_nearest_place_is_where_the_closed_form_says(gap: float) -> None:
    """Crank along the bases is the middle of the path; the distance of type 2 there, of coupler and
    rocker nearly in line, is the least of a dense sampling, though only the ends of the path are
    samples.
    """
    mechanism = parallelogram(gap)
    found = track(mechanism, joints=[[1.0], [-1.0]])
    dense = track(mechanism, joints=[[0.05], [-0.05]], samples=401, start=None)
    assert found.reached
    assert found.nearest is not None
    assert abs(found.nearest.parameter - 0.5) < 0.02
    least = min(s.smallest_singular_value for s in dense.samples) if dense.samples else math.inf
    assert found.nearest.smallest_singular_value <= least * (1 + 1e-6)
    assert found.nearest.residual < 1e-9


@pytest.mark.parametrize("kind", ["joints", "poses"])
def test_the_nearest_place_of_any_path(kind: str) -> None:
    """Not above the least of a hundred samples, and one of them is near it; direct and inverse,
    limbs with steps of their own.
    """
    mechanism = three_rrr("planar")
    rest = symkin.solve(mechanism).solution
    if kind == "joints":
        rows = [
            list(rest.actuated_values),
            [v + d for v, d in zip(rest.actuated_values, (0.25, -0.1, 0.15), strict=True)],
        ]
    else:
        pose = [*rest.position, *rest.quaternion]
        rows = [pose, [pose[0] + 12.0, pose[1] - 9.0, *pose[2:]]]
    found = track(mechanism, **{kind: rows})
    dense = track(mechanism, **{kind: rows}, samples=101)
    assert found.nearest is not None
    samples = {s.parameter: s.smallest_singular_value for s in dense.samples}
    assert found.nearest.smallest_singular_value <= min(samples.values()) * (1 + 1e-6)
    assert found.nearest.smallest_singular_value > 0.98 * min(samples.values())


def test_the_summary_and_the_json_name_it() -> None:
    found = track(four_bar()[0], joints=[[1.0], [1.2]])
    content = json.loads(json.dumps(found.to_dict(), allow_nan=False))["nearest"]
    assert set(content) == {"parameter", "time", "smallest_singular_value", "distances"}
    assert content["distances"] == symkin.singularity(found.nearest.solution).distances
    assert f"nearest to a singularity at {content['parameter']:.9g} of the path" in str(found)


def three_rpr() -> Mechanism:
    """Base and platform are similar triangles of radius 100 and 40: at the reference all three rods
    meet in the centre.
    """
    limbs = []
    for k in range(3):
        outward = np.array(
            [math.cos(2 * math.pi * k / 3 + 0.3), math.sin(2 * math.pi * k / 3 + 0.3), 0.0]
        )
        base, end = tuple((100.0 * outward).tolist()), tuple((40.0 * outward).tolist())
        rod = Joint(f"rod{k}", "P", base, tuple((-outward).tolist()), actuated=True)
        limbs.append(
            Limb(f"limb{k}", [Joint(f"turn{k}", "R", base, Z), rod, Joint(f"end{k}", "R", end, Z)])
        )
    return Mechanism("three_rpr", limbs, motion="planar")


def test_a_path_of_poses_tells_where_its_motors_hold_the_pose_no_longer() -> None:
    """Rods that meet in a point leave the platform a turn about it: type 2, at the middle of the
    path, where the joints' own problem is regular and the track goes on.
    """
    half = math.radians(10.0)
    ends = [
        [0.0, 0.0, 0.0, math.cos(half), 0.0, 0.0, turn]
        for turn in (-math.sin(half), math.sin(half))
    ]
    found = track(three_rpr(), poses=ends, samples=21)
    assert found.reached
    assert (
        "of 21 samples the one at 0.5 of the path is nearest to where the motors no longer tell "
        "the pose: type 2 " in str(found)
    )
    assert symkin.singularity(found.samples[10].solution).distances["type 2"] < 1e-12
    assert "no longer tell the pose" not in str(
        track(three_rrr("planar"), joints=[[0.0] * 3, [0.1] * 3])
    )


def test_an_arm_whose_pose_is_a_formula_has_none() -> None:
    arm = symkin.load("gluon_6l3")
    found = track(arm, joints=[[10.0] * 6, [20.0] * 6])
    assert found.nearest is None
    assert found.to_dict()["nearest"] is None
