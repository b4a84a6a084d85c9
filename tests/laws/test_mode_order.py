"""Modes stand in order of their distance from the reference, the nearest first."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.inside import places_by

GALLERY = json.loads((Path(__file__).parents[1] / "data" / "gallery.json").read_text())


@pytest.mark.parametrize("name", ["four_bar", "watt_six_bar", "slider_crank"])
def test_modes_of_graphs_begin_beside_the_reference(name: str) -> None:
    """Without a platform by their coordinates: chords of angles, lengths over the size."""
    found = symkin.modes(symkin.load(name), given=GALLERY[name]["cases"][0]["given"])
    closure = found.problem.closure
    assert len(found) > 1
    assert found.problem.mechanism.platform_link is None
    distances = np.zeros(len(found))
    for c in closure.coordinates:
        own = np.array([mode.variables[closure.slices[c.name].start] for mode in found])
        reference = closure.reference[closure.slices[c.name].start]
        if c.kind == "angle":
            distances += np.abs(np.exp(1j * own) - np.exp(1j * reference)) ** 2
        else:
            distances += ((own - reference) / closure.characteristic_length) ** 2
    assert np.all(np.diff(distances) >= -1e-9)


@pytest.mark.parametrize("count", [0, 2, 65, 3000])
def test_many_modes_stand_as_all_their_numbers_say(count: int) -> None:
    """Ties are told column by column, as all columns at once would tell them."""
    rng = np.random.default_rng(count)
    owner = np.sort(rng.integers(0, count // 4 + 1, count))
    first = rng.integers(0, 2, count) * 0.5
    values = rng.integers(-2, 2, (count, 5)) * 0.5 + rng.normal(size=(count, 5)) * 1e-9
    values[:, 1] = 1.0
    every = np.lexsort((*values.T[::-1].round(6), first, owner))
    assert np.array_equal(places_by(owner, first, values), every)
