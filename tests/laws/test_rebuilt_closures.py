"""A closure that something holds is the machine's only one, however many others were built since:
another would have other symbols, of which what is kept knows nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.inside import (
    build_closure,
    build_model,
    build_problem,
    observed,
    solve_configurations,
    velocity_equations,
)
from symkin import Mechanism, jacobian


def bench(name: str) -> Mechanism:
    legs = [
        symkin.RodLimb(f"leg{k}", [x, y, 0], [0.4 * x, 0.4 * y, 0])
        for k, (x, y) in enumerate(_CORNERS)
    ]
    return Mechanism(name, legs, platform_position=[0, 0, 300])


_CORNERS = [(200, 10), (110, 170), (-90, 180), (-200, 20), (-110, -170), (100, -180)]


def test_a_model_is_made_of_one_closure():
    """As many mechanisms as are kept come between what is read and the model over it."""
    mechanism = bench("first")
    kept = observed(mechanism, ())
    for k in range(140):
        build_closure(bench(f"other{k}"))
    assert build_closure(mechanism) is kept.closure
    joints = np.array([[c.reference[0] for c in mechanism.actuated]])
    data = symkin.Measurements(joints, position=np.array([[0.0, 0.0, 300.0]]))
    model = build_model(mechanism, data, ())
    assert solve_configurations(model, data, np.zeros(0)).solved.all()


def test_what_is_kept_of_a_machine_and_what_is_made_later_have_one_closure():
    """Problems, velocity equations and closures are kept apart, so many each: a Jacobian is made of
    kept equations, generated code of a kept problem and a new one.
    """
    mechanism = replace(symkin.load("zhao2000"), name="kept")
    velocity_equations(mechanism, mechanism.characteristic_length, bound=True)
    poses = build_problem(mechanism, "inverse")
    for k in range(140):
        build_closure(bench(f"later{k}"))
    assert build_problem(mechanism, "direct").closure is poses.closure
    home = symkin.solve(mechanism, joints=mechanism.example.joints).solution
    direct, inverse = (jacobian(mechanism, kind).at(home) for kind in ("direct", "inverse"))
    assert direct @ inverse @ direct == pytest.approx(direct, rel=1e-9, abs=1e-12)
