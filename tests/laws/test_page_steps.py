"""The steps by which a page finds all solutions: their starts solve them, and are as many as
`modes` counts.
"""

from __future__ import annotations

from math import prod

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.gate import in_gate_but
from helpers.inside import groups_of, page_model, steps_of, vectorise
from symkin import Mechanism

NAMES = ["zhang2009", "zhao2000", "zhao2000_links", "ankle", "excavator_bucket", "planetary_gear"]


def steps(mechanism: Mechanism):
    """Groups and steps at the mechanism's first mode, and the units of its variables."""
    model = page_model(mechanism).model
    modes = symkin.modes(mechanism)
    groups = groups_of(modes.problem)
    columns = np.array(model["columns"])
    found, _ = steps_of(groups, modes[0], modes[0].variables[None], columns)
    return modes, groups, found, columns


@pytest.mark.parametrize("name", in_gate_but(NAMES, ["zhao2000_links"]))
def test_starts_are_all_complex_solutions(name):
    """Rows vanish at each start; no two of them are one; the product of the steps' numbers of
    solutions is the count of `modes`."""
    modes, groups, found, columns = steps(symkin.load(name))
    counts = []
    for group, step in zip(groups, found, strict=True):
        counts.append(len(step["signs"] or step["starts"]))
        if not step["starts"]:
            continue
        pairs = np.array(step["starts"]).reshape(len(step["starts"]), -1, 2)
        starts = pairs[:, :, 0] + 1j * pairs[:, :, 1]
        x, places = group.closure.variables, step["known"] + step["unknown"]
        values = np.zeros((len(starts), len(columns)), dtype=complex)
        values[:, places] = starts
        rows = np.zeros((len(starts), int(group.system.rows.shape[0]), 1), dtype=complex)
        vectorise(ca.Function("rows", [x], [group.system.rows], {"cse": True}))(values.T, rows)
        size = np.max(np.abs(starts) / columns[places], axis=1, initial=1.0)[:, None]
        assert (
            np.max(np.abs(rows[:, :, 0]) / size**2)
            < 1e-9 * modes.problem.mechanism.characteristic_length
        )
        gaps = np.max(np.abs(starts[:, None] - starts[None]) / columns[places], axis=2)
        gaps[np.diag_indices(len(gaps))] = np.inf
        assert np.min(gaps) > 1e-6
    assert prod(counts) == modes.complex_count


def test_formulas_have_no_path_where_they_keep_their_digits():
    """Values, discriminants and margins of a closed form are those that `solutions` goes by."""
    _, groups, found, _ = steps(symkin.load("four_bar"))
    (step,) = found
    assert len(step["signs"]) == 2
    assert step["margins"] > 0
    assert step["starts"]
    assert groups[0].unknown_places.tolist() == step["unknown"]
