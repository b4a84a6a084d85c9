"""Mechanisms that are singular at every configuration, redundant or short arms, and solutions that
are classified as they are.
"""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import symkin
from helpers.inside import build_problem, classify, make_solution
from helpers.samples import delta, four_bar, pieper, random_mechanism, three_rrr
from symkin import InputError, Joint, Limb, Mechanism, Singularity, singularity


def equal_upu() -> Mechanism:
    """A 3-UPU declared to translate whose base and platform are equal triangles: the legs stay
    parallel.
    """
    limbs = []
    for k, angle in enumerate(np.radians([0, 120, 240]), start=1):
        r, t = (math.cos(angle), math.sin(angle), 0.0), (-math.sin(angle), math.cos(angle), 0.0)
        foot, head = tuple(200 * np.array(r)), tuple(200 * np.array(r) + [0, 0, 300.0])
        joints = [
            Joint(f"u{k}", "U", foot, axis=t, axis2=r),
            Joint(f"d{k}", "P", axis=(0.0, 0.0, 1.0), actuated=True, zero=300.0),
            Joint(f"v{k}", "U", head, axis=r, axis2=t),
        ]
        limbs.append(Limb(f"leg{k}", joints))
    return Mechanism("equal_upu", limbs, platform_position=(0.0, 0.0, 300.0), motion="translation")


def planar_arm(joints: int) -> Mechanism:
    """Parallel revolutes 300 apart."""
    made = [
        Joint(f"q{k}", "R", (300.0 * k, 0.0, 0.0), (0.0, 0.0, 1.0), actuated=True)
        for k in range(joints)
    ]
    return Mechanism(
        "planar", [Limb("planar", made)], serial=True, platform_position=(300.0 * joints, 0.0, 0.0)
    )


@pytest.fixture(scope="module")
def loose() -> Singularity:
    return singularity(equal_upu(), joints=[300.0, 300.0, 300.0])


def test_a_platform_that_is_loose_everywhere_is_not_called_regular(loose: Singularity) -> None:
    """Three equal parallel legs are one leg: with all lengths held the platform keeps two
    translations everywhere.
    """
    text = str(loose)
    assert loose.uncontrolled_freedoms == 2
    assert loose.is_singular
    assert "regular" not in text
    assert (
        "singular everywhere: with all actuated joints held the platform keeps 2 freedoms" in text
    )
    assert "(from more than the 2 everywhere)" in text


def test_no_finite_map_leads_from_the_joints_of_a_loose_platform(loose: Singularity) -> None:
    """The condition is infinite in the text and null in the JSON, as that of the solution itself;
    `everywhere` counts what the distances leave out.
    """
    assert math.isinf(loose.condition)
    assert math.isinf(loose.manipulability)
    content = json.loads(json.dumps(loose.to_dict(), allow_nan=False))
    assert content["condition"] is None
    assert content["everywhere"] == {"type 2": 2}


def test_the_twists_of_a_loose_platform_keep_all_lengths(loose: Singularity) -> None:
    """They are two independent translations across the common direction of the legs."""
    leg = loose.solution.position
    twists = np.array([twist.vector for twist in loose.twists])
    assert np.linalg.matrix_rank(twists, tol=1e-9) == 2
    assert np.abs(twists[:, :3]).max() < 1e-9
    assert np.abs(twists[:, 3:] @ leg).max() < 1e-9 * np.linalg.norm(leg)


@pytest.mark.parametrize(
    "limbs", [("rRS", "rRS", "rRS"), ("rS", "rS"), ("rPS", "rHS", "pSR"), ("rRRR",)], ids="-".join
)
def test_regular_says_that_the_actuated_joints_hold_the_platform(limbs: tuple[str, ...]) -> None:
    """Of random mechanisms only those are headed regular whose platform has no motion with the
    actuated joints held.
    """
    mechanism = random_mechanism(np.random.default_rng(9), limbs)
    problem = build_problem(mechanism, "direct")
    found = classify(make_solution(problem, problem.closure.reference))
    free = found.equations.twist.shape[1] - np.linalg.matrix_rank(found.equations.twist, tol=1e-9)
    assert ("\nregular" in str(found)) == (not found.kinds and free == 0)
    assert (free > 0) == (found.uncontrolled_freedoms > 0 or "type 2" in found.kinds)


@pytest.mark.parametrize(
    "mechanism", [four_bar()[0], three_rrr("planar"), delta(), pieper()], ids=lambda m: m.name
)
def test_mechanisms_with_nothing_free_say_nothing_of_it(mechanism: Mechanism) -> None:
    """`everywhere` is empty, and the distances stand without a remark."""
    problem = build_problem(mechanism, "direct")
    found = classify(make_solution(problem, problem.closure.reference))
    assert found.permanent_freedoms == {}
    assert "everywhere" not in str(found)


def test_a_redundant_arm_says_what_its_distance_leaves_out() -> None:
    """Four parallel revolutes move with the tool at rest in one freedom, in every configuration."""
    found = singularity(planar_arm(4), joints=[0.1, 0.5, 0.7, 0.4])
    assert found.kinds == ()
    assert found.permanent_freedoms == {"type 1": 1}
    assert "freedoms of the actuated joints with the platform at rest, everywhere: 1" in found.notes


@pytest.mark.parametrize(("joints", "kinds"), [(2, ()), (3, ("type 1",))])
def test_a_short_arm_says_what_type_1_means(joints: int, kinds: tuple[str, ...]) -> None:
    """Stretched, two parallel revolutes cannot move with the tool at rest, its turn included; three
    can. The tool has not all of its six freedoms, and a note says what is classified.
    """
    found = singularity(planar_arm(joints), joints=[0.0] * joints)
    assert found.kinds == kinds
    assert any(
        f"with {joints} joints the tool has {joints} of 6 freedoms" in note for note in found.notes
    )


def test_an_arm_of_six_freedoms_has_no_such_note() -> None:
    """A 6R arm that is not singular has no note at all."""
    assert singularity(pieper(), joints=[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]).notes == ()


# --- what is accepted -----------------------------------------------------------------------------


def test_a_solution_is_classified_as_it_is() -> None:
    """A Solution, from `solve` or `modes`, gives what its mechanism and joints give."""
    mechanism = three_rrr("planar")
    joints = [c.reference[0] for c in mechanism.actuated]
    modes = symkin.modes(mechanism, joints=joints)
    assert len(modes) > 0
    for mode in modes:
        assert symkin.singularity(mode).distances == pytest.approx(classify(mode).distances)
    solution = symkin.solve(pieper(), joints=[0.1, 0.2, 0.3, 0.4, 0.0, 0.6]).solution
    assert symkin.singularity(solution).kinds == ("type 1",)


def test_what_is_no_mechanism_is_refused() -> None:
    """One sentence that says what to call; a Solution takes no joints."""
    result = symkin.solve(pieper(), joints=[0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    with pytest.raises(
        InputError,
        match=r"a SolveResult is given; allowed: a Mechanism, or a Solution, such as .*\.solution",
    ):
        symkin.singularity(result)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="a Solution is classified as it is"):
        symkin.singularity(result.solution, joints=[0.0] * 6)
