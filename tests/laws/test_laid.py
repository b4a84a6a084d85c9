"""A machine whose limbs are laid along axes is the machine that is described: at the same values of
its actuated joints its platform stands where that one's does.
"""

import pickle
from dataclasses import fields, replace
from functools import partial

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers import samples
from helpers.inside import (
    Machine,
    build_closure,
    build_problem,
    configurations,
    is_laid,
    lowered_limbs,
    with_reference_at,
)
from helpers.spellings import MACHINES
from symkin import Joint, Limb, Mechanism, Pose

SPELLED = ("3-RRR", "Tricept", "3-RUU", "ankle")


def three_rsr() -> Mechanism:
    """Three limbs of a driven hinge, a ball and a hinge on the platform, anywhere."""
    rng = np.random.default_rng(2)
    limbs = []
    for k in range(3):
        foot, ball, end = rng.normal(size=(3, 3)) + [[0, 0, 0], [0, 0, 2], [0, 0, 4]]
        joints = [
            Joint(f"motor{k}", "R", foot, samples.unit(rng), actuated=True, zero=0.4),
            Joint(f"ball{k}", "S", ball),
            Joint(f"hinge{k}", "R", end, samples.unit(rng)),
        ]
        limbs.append(Limb(f"limb{k}", joints))
    turn = (0.8, *(0.6 * np.array(samples.unit(rng))))
    return Mechanism("three_rsr", limbs, (0.3, 0.1, 4.0), turn, length_unit="m")


def elsewhere(name: str) -> Mechanism:
    """A machine described at another of its configurations."""
    machine = MACHINES[name]()
    there = machine.configuration
    return with_reference_at(build_closure(machine.home, there.partition), there.variables)


def zhao2000_links() -> Mechanism:
    """Its machine as limbs that carry rods."""
    laid = lowered_limbs(symkin.load("zhao2000_links")).machine
    return Mechanism(**{f.name: getattr(laid, f.name) for f in fields(Mechanism)})


def reached(machine: Mechanism) -> np.ndarray:
    """Values of the actuated joints and the platform's position and rotation at configurations
    that the machine reaches from the reference.
    """
    direct = build_problem(machine, "direct")
    closure, rows = direct.closure, []
    parts = [closure.bound(part) for part in (closure.pose.position, closure.pose.quaternion)]
    pose = ca.Function("pose", [closure.variables], parts)
    for one in configurations(direct, closure.reference, 3, 0):
        at = Pose(*(np.asarray(part).ravel() for part in pose(one.values)))
        rows.append(np.concatenate([one.known, at.position, np.ravel(at.rotation)]))
    return np.array(rows)


@pytest.mark.parametrize(
    "maker",
    [
        *(pytest.param(partial(elsewhere, name), id=name) for name in SPELLED),
        pytest.param(zhao2000_links, id="zhao2000_links"),
        pytest.param(three_rsr, id="3-RSR"),
    ],
)
def test_a_laid_machine_is_the_one_that_is_described(maker) -> None:
    described = maker()
    laid = Machine.of(described, laid=True)
    size = described.characteristic_length
    wanted, found = reached(described), reached(laid)
    assert len(wanted) == 3
    np.testing.assert_allclose(found, wanted, atol=1e-9 * max(size, 1.0))
    numbers = [build_closure(machine).parameter_values.tolist() for machine in (described, laid)]
    assert numbers[0] != numbers[1]


def test_a_laid_machine_is_no_mechanism_that_a_user_can_tell() -> None:
    """It stays laid where it is changed or pickled, and no cache takes it for the mechanism."""
    mechanism = symkin.load("delta")
    laid = lowered_limbs(mechanism).machine
    assert laid != mechanism
    assert not {"laid", "told_in"} & {f.name for f in fields(mechanism)}
    for again in (replace(laid, title="another"), pickle.loads(pickle.dumps(laid))):
        assert is_laid(again)
    assert pickle.loads(pickle.dumps(laid)) == laid
