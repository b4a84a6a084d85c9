"""Closures that are built anew, since many others were, have other symbols: what is kept of the
first ones goes on to be right.
"""

from __future__ import annotations

import numpy as np

import symkin
from helpers.inside import build_closure, build_model, observed, solve_configurations
from symkin import Mechanism


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
    assert build_closure(mechanism) is not kept.closure
    joints = np.array([[c.reference[0] for c in mechanism.actuated]])
    data = symkin.Measurements(joints, position=np.array([[0.0, 0.0, 300.0]]))
    model = build_model(mechanism, data, ())
    assert solve_configurations(model, data, np.zeros(0)).solved.all()
