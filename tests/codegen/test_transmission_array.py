"""Array files of transmissions: the verb's numbers, NaN where there is none, exact derivatives
under JAX.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import array_source
from helpers.transmissions import transmission

MACHINES = ["g1", "four_bar", "five_bar", "six_bar", "digit_knee", "digit_ankle", "ankle"]
QUICK = ["g1", "four_bar", "five_bar"]


@cache
def text(name: str) -> str:
    return array_source(transmission(name))


def module(name: str, folder: Path) -> ModuleType:
    path = folder / "some_transmission.py"
    path.write_text(text(name), encoding="utf-8")
    spec = importlib.util.spec_from_file_location("some_transmission", path)
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


@pytest.fixture(params=in_gate(MACHINES, QUICK))
def pair(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[symkin.Transmission, ModuleType]:
    return transmission(request.param), module(request.param, tmp_path)


def test_numbers_are_those_of_the_verb(pair: tuple[symkin.Transmission, ModuleType]) -> None:
    """Joints, motors, Jacobian and second derivatives over the range; a batch of any shape; answers
    leave no residual.
    """
    found, made = pair
    states = found.survey.states
    joints, motors = made.joints(states.motors), made.motors(states.joints)
    inside = np.isfinite(joints).all(axis=1)
    assert inside.mean() > 0.97
    assert np.abs(joints - states.joints)[inside].max() < 1e-9
    assert np.nanmax(np.abs(motors - states.motors)) < 1e-8
    assert np.nanmax(np.abs(made.residual(states.motors, states.joints))) < 1e-12
    scale = np.abs(states.jacobian).max()
    assert (
        np.abs(made.jacobian(states.motors, states.joints) - states.jacobian).max() < 1e-8 * scale
    )
    bend = np.abs(states.second).max()
    assert np.abs(made.second(states.motors, states.joints) - states.second).max() < 1e-7 * bend
    some = states.motors[:6].reshape(2, 3, -1)
    assert np.array_equal(made.joints(some), joints[:6].reshape(2, 3, -1), equal_nan=True)


def test_file_stands_alone() -> None:
    """It imports NumPy and the standard library only."""
    lines = [line for line in text("g1").splitlines() if line.startswith(("import ", "from "))]
    assert lines == ["import itertools", "import numpy"]


def test_what_is_no_answer_is_nan(tmp_path: Path) -> None:
    """Beyond the range, from a guess on another mode, and for motors of other joints: NaN."""
    made, found = module("g1", tmp_path), transmission("g1")
    assert np.isnan(made.joints(np.array([3.0, 0.1]))).all()
    with np.errstate(invalid="ignore"):
        assert np.isnan(made.motors(np.array([0.1, 3.0]))).any()
        joints = found.joints_of([0.2, -0.1])
        assert np.isnan(made.motors(joints, guess=np.array([3.0, 3.0]))).any()
    assert np.isnan(made.jacobian(np.array([0.3, -0.1]), joints)).all()
    assert np.isnan(made.joints(np.array([0.2, -0.1]), guess=np.array([1.5, 2.0]))).all()
    near = made.joints(np.array([0.2, -0.1]), guess=joints + 0.05)
    assert np.abs(near - joints).max() < 1e-13


def test_no_goal_leaves_its_branch(tmp_path: Path) -> None:
    """Whatever the goal, the joints are those that the verb follows there, or NaN."""
    made, found = module("g1", tmp_path), transmission("g1")
    goals = np.random.default_rng(8).uniform(-1.5, 1.5, (1500, 2))
    mine, followed = made.joints(goals), found.joints_of(goals, check=False)
    both = np.isfinite(mine).all(axis=1)
    assert both.sum() > 500
    assert np.abs(mine - followed)[both].max() < 1e-9


@pytest.fixture
def jax() -> Iterator[Any]:
    """JAX with doubles, and without optimisations that take longer than what they save here."""
    jax: Any = pytest.importorskip("jax")
    jax.config.update("jax_disable_most_optimizations", True)
    with jax.enable_x64(True):
        yield jax
    jax.config.update("jax_disable_most_optimizations", False)


def test_jax_gives_the_same_numbers(tmp_path: Path, jax: Any) -> None:
    """Under jit and vmap joints and second derivatives are those of NumPy to 1e-13."""
    made, xp = module("g1", tmp_path), jax.numpy
    some = transmission("g1").survey.states.motors[::40]

    def both(motors: Any) -> Any:
        joints = made.joints(motors, xp=xp)
        return joints, made.second(motors, joints, xp=xp)

    joints, second = (np.asarray(part) for part in jax.jit(jax.vmap(both))(some))
    assert np.abs(joints - made.joints(some)).max() < 1e-13
    assert np.abs(second - made.second(some, made.joints(some))).max() < 1e-13


@pytest.mark.long
def test_jax_derivatives_are_exact(tmp_path: Path, jax: Any) -> None:
    """The derivatives of the iteration are J, its own the second derivatives; a loss has a
    gradient.
    """
    made, found, xp = module("g1", tmp_path), transmission("g1"), jax.numpy
    some = found.survey.states.motors[::40]
    states = found.states(some)

    def joints(motors: Any) -> Any:
        return made.joints(motors, xp=xp)

    slopes = np.asarray(jax.jit(jax.vmap(jax.jacfwd(joints)))(some))
    assert np.abs(slopes - states.jacobian).max() < 1e-12
    bends = np.asarray(jax.jit(jax.vmap(jax.jacfwd(jax.jacfwd(joints))))(some))
    assert np.abs(bends - states.second).max() < 1e-11
    slope = jax.jit(jax.grad(lambda motors: xp.sum(joints(motors) ** 2)))(xp.asarray(some))
    wanted = 2.0 * np.einsum("nia,ni->na", states.jacobian, states.joints)
    assert np.abs(np.asarray(slope) - wanted).max() < 1e-12


def test_linkages_without_formulas_are_refused() -> None:
    """A file is refused with the reason where motors and joints differ in number."""
    with pytest.raises(symkin.InputError, match="as many motors as joints"):
        array_source(transmission("redundant"))
