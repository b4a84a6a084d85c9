"""Laws of singularities that hold for every mechanism: units, frames, distances, wrenches."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.inside import (
    SINGULAR_VALUE,
    Roles,
    classify,
    displaced,
    generic_ranks,
    motion_ranks,
    scaled,
)
from helpers.laws import assert_wrenches_do_no_work
from helpers.moved_mechanisms import reference_solution
from helpers.samples import (
    delta,
    five_bar,
    four_bar,
    hexagons,
    pieper,
    planar_pose,
    random_mechanism,
    three_rps,
    three_rrr,
    tilted_rps,
)
from symkin import Mechanism, Singularity, SolveError, singularity


@pytest.mark.parametrize("seed", range(3))
def test_wrenches_of_a_random_singular_arm_do_no_work(seed: int) -> None:
    """At a wrist singularity with any other joints five twists are feasible, and the wrench does no
    work on them.
    """
    q = np.random.default_rng(seed).uniform(-2, 2, 6)
    found = singularity(pieper(), joints=[*q[:4], 0.0, q[5]])
    assert len(found.feasible_twists) == 5
    assert len(found.wrenches) == 1
    assert_wrenches_do_no_work(found)


MECHANISMS = [
    four_bar()[0],
    five_bar(),
    three_rrr(),
    three_rrr("planar"),
    delta(),
    three_rps(),
    pieper(),
    hexagons(),
]


@pytest.mark.slow
@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda m: f"{m.name}-{m.motion}")
def test_distances_do_not_depend_on_the_length_unit(mechanism: Mechanism) -> None:
    """The same machine in metres has the same distances, condition and (angles times the size)
    manipulability.
    """
    metres = scaled(mechanism, 1e-3)
    a, b = classify(reference_solution(mechanism)), classify(reference_solution(metres))
    assert a.kinds == b.kinds
    for kind, value in a.distances.items():
        assert b.distances[kind] == pytest.approx(value, rel=1e-9, abs=1e-12)
    assert b.singular_values == pytest.approx(a.singular_values, rel=1e-8, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    "mechanism", [m for m in MECHANISMS if m.motion == "spatial"], ids=lambda m: m.name
)
def test_distances_do_not_depend_on_the_base_frame(mechanism: Mechanism) -> None:
    """A machine moved as a whole in its base frame has the same distances and the same direct map
    (a declared motion is along the axes of the base frame, so that it is left out).
    """
    moved = displaced(
        mechanism, symkin.Pose(np.array([30.0, -70.0, 110.0]), np.array([0.5, 0.5, -0.5, 0.5]))
    )
    tilted = displaced(
        mechanism, symkin.Pose(np.array([3.0, 7.0, -1.0]), np.array([0.8, 0.0, 0.36, 0.48]))
    )
    a = classify(reference_solution(mechanism))
    for other in (moved, tilted):
        b = classify(reference_solution(other))
        assert a.kinds == b.kinds
        for kind, value in a.distances.items():
            assert b.distances[kind] == pytest.approx(value, rel=1e-9, abs=1e-12)
        assert b.singular_values == pytest.approx(a.singular_values, rel=1e-8, abs=1e-12)


RANDOM = (
    ("rRS", "rRS", "rRS"),
    ("pUS", "pUS", "pUS", "SPS", "SPS", "SPS"),
    ("hRRRRR", "SPS", "SPS", "SPS", "SPS", "SPS"),
    ("UpU", "UpU", "UpU"),
    ("CpC", "SPS", "rUS", "SPS"),
    ("rPS", "rHS", "pSR"),
    ("rRRR",),
    ("rS", "rS"),
)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("limbs", RANDOM, ids="-".join)
def test_random_mechanisms_in_other_units_and_frames(limbs: tuple[str, ...]) -> None:
    """Every joint type: distances and kinds of a random mechanism are those of the same one in
    metres and placed elsewhere.
    """
    mechanism = random_mechanism(np.random.default_rng(len(limbs)), limbs)
    a = classify(reference_solution(mechanism))
    where = symkin.Pose(np.array([30.0, -70.0, 110.0]), np.array([0.5, -0.5, 0.5, 0.5]))
    for other in (scaled(mechanism, 1e-3), displaced(mechanism, where)):
        b = classify(reference_solution(other))
        assert a.kinds == b.kinds
        assert b.distances == pytest.approx(a.distances, rel=1e-7, abs=1e-10)


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda m: f"{m.name}-{m.motion}")
def test_limb_rows_are_orthonormal_and_hold_on_closed_motions(mechanism: Mechanism) -> None:
    """a a^T + b b^T = 1 limb by limb, and the direct map times the inverse map is the identity:
    their singular values are reciprocal.
    """
    found = classify(reference_solution(mechanism))
    for limb in found.equations.limbs:
        rows = np.hstack([limb.twist, limb.rates])
        assert np.allclose(rows @ rows.T, np.eye(len(rows)), atol=1e-12)
    if not found.kinds:
        assert found.manipulability * found.inverse_manipulability == pytest.approx(1.0)


def test_the_distance_is_that_to_the_nearest_singular_rows() -> None:
    """Eckart and Young: some change of the rows of that 2-norm makes them singular, and no smaller
    one does.
    """
    found = singularity(symkin.load("zhang2009"))
    left, singular, right = np.linalg.svd(found.equations.twist)
    change = singular[-1] * np.outer(left[:, -1], right[-1])
    assert found.distances["type 2"] == pytest.approx(np.linalg.norm(change, 2))
    assert np.linalg.svd(found.equations.twist - change, compute_uv=False)[-1] < 1e-12


def test_generic_ranks_of_shipped_mechanisms() -> None:
    """Platforms and arms of six freedoms have six motions, the 3-TRT + SPS four, with two
    independent constraints.
    """
    ranks = {
        name: generic_ranks(Roles.of_limbs(symkin.load(name)))
        for name in ("zhang2009", "gluon_6l3", "zhao2000_links")
    }
    assert [r.motions for r in ranks.values()] == [6, 6, 4]
    assert [r.constraints for r in ranks.values()] == [0, 0, 2]


@pytest.mark.parametrize("first", [True, False])
def test_a_singular_configuration_among_others_changes_no_generic_rank(
    first: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An arm with its wrist stretched, where its joints' screws depend on each other, before or
    behind a regular configuration.
    """
    arm = replace(pieper(), name=f"arm_{first}")
    bent, stretched = (
        symkin.solve(arm, joints=[0.3, 0.5, 0.7, 0.9, wrist, 1.1]).solution.variables
        for wrist in (1.0, 0.0)
    )
    monkeypatch.setattr(
        motion_ranks,
        "closed_configurations",
        lambda *_: [stretched, bent] if first else [bent, stretched],
    )
    assert generic_ranks(Roles.of_limbs(arm)).rates == 6
    monkeypatch.setattr(motion_ranks, "closed_configurations", lambda *_: [stretched])
    assert generic_ranks(Roles.of_limbs(replace(arm, name=f"stretched_{first}"))).rates < 6


def assert_verdict_and_distances_agree(found: Singularity) -> None:
    """A kind is named where its distance is below the tolerance, and nowhere else."""
    for kind, value in found.distances.items():
        assert (kind in found.kinds) == (value < SINGULAR_VALUE)
    assert math.isinf(found.manipulability) == ("type 2" in found.kinds)


@pytest.mark.parametrize("turn", [*np.pi / 2 + np.geomspace(1e-9, 1e-2, 22), math.pi / 2])
def test_verdict_and_distances_agree_near_type_2(turn: float) -> None:
    """Hexagons turned near 90 degrees pass through the tolerance."""
    assert_verdict_and_distances_agree(
        singularity(
            hexagons(), pose=planar_pose(0, 0, turn)[:2] + [120, *planar_pose(0, 0, turn)[3:]]
        )
    )


@pytest.mark.parametrize("off", np.geomspace(1e-9, 1e-2, 15))
def test_verdict_and_distances_agree_near_two_kinds(off: float) -> None:
    """A 3-RPS on its way to a type 2 singularity beside a constraint singularity, where ranks of
    motions alone miss it.
    """
    mechanism = tilted_rps()
    start = [-76.717, 64.144, 92.210, 0, -0.34119, 0.93999, 0]
    joints = [317.135906, 99.664134 + off, mechanism.actuated[2].reference[0]]
    try:
        found = singularity(mechanism, joints=joints, start=start)
    except SolveError:
        pytest.skip("beyond the fold")
    assert_verdict_and_distances_agree(found)
