"""Random graphs followed along one of their coordinates: closure and freedoms at each end by the
plain graph, which shares nothing with symkin.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symkin
from campaigns.random_graphs import Drawing, chosen_values
from helpers.gate import in_gate
from oracle.plain_check import plain_configurations
from oracle.plain_graph import freedom

FAR = 1.5
"""How far a coordinate is moved (rad, or half of it times the size): most paths stop before."""


@pytest.mark.slow
@pytest.mark.parametrize("index", in_gate([2, 5, 7, 12, 21, 35, 38, 51], [2, 7, 21]))
def test_random_graphs_are_followed_to_a_singularity_or_the_end(index: int, tmp_path: Path) -> None:
    """Every sample closes the plain graph. At a stop, with the given coordinates held, as many
    motions are free as are said, and block and loop are named; at a reached end none is.
    """
    rng = np.random.default_rng([7, index])
    path = tmp_path / "graph.toml"
    path.write_text(Drawing(rng).grow())
    chosen = chosen_values(path, rng)
    assert chosen is not None
    mechanism, given = symkin.load(path), chosen[0]
    moved = next(c for c in mechanism.coordinates if c.name in given)
    step = FAR if moved.is_angular else 0.5 * mechanism.characteristic_length
    paths = {
        name: [value, value + step] if name == moved.name else value
        for name, value in given.items()
    }
    found = symkin.track(mechanism, given=paths, samples=5, name_modes=False)
    g, x = plain_configurations(
        path, found.problem.closure, np.array([sample.values for sample in found.samples])
    )
    assert float(np.max(np.abs(g.closure(x)[0]))) < 1e-9
    held = {6 * len(g.names) + k for k, c in enumerate(g.coordinates) if c.name in given}
    free = freedom(g, x[-1], np.array([k for k in range(g.freedom) if k not in held]))[1]
    end = symkin.singularity(found.end.solution, given=list(given))
    assert end.rank_loss == len(end.motions) == free
    if found.stop is None:
        assert (free, end.kinds) == (0, ())
        return
    assert found.stop.kind == "turning point"
    assert free == 1
    assert found.stop.groups == end.groups
    assert all(group.loops for group in end.groups)
