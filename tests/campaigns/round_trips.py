"""Random machines through MJCF, URDF (loops in it and beside it) and SDF and back: the same names
mean the same.

    python tests/campaigns/round_trips.py [--count 500] [--seed 0]

Machines are graphs with joints of every type, told from either link, rods, welds and couplings, and
platforms on limbs. What is read must be what was written, with the same values of the same names
for the same link poses by matrix exponentials (scipy), and written again the same once more.
Refused are only couplings that a format says it cannot hold. Each finding names the machine. Exit
status 1 where anything was found.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import symkin
from helpers.inside import as_graph
from helpers.random_graphs import random_graph
from helpers.same_mechanism import assert_same
from helpers.samples import random_mechanism

FORMS = {"MJCF": ".xml", "URDF": ".urdf", "URDF and YAML": ".urdf", "SDF": ".sdf"}
LIMBS = ("SPS", "uRR", "RUC", "hS", "pUS", "CU", "rRS", "RRrRR", "SUp")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(options.seed, options.seed + options.count):
            for name, finding in findings(seed, Path(folder)):
                counts[name] += 1
                counts["found"] += finding is not None
                if finding is not None:
                    print(f"seed {seed}, {name}: {finding}", flush=True)
    print(", ".join(f"{name} {count}" for name, count in counts.items()))
    return int(counts["found"] > 0)


def findings(seed: int, folder: Path) -> Iterator[tuple[str, str | None]]:
    """What each form of one machine comes back as: None where it is the same."""
    for name, suffix in FORMS.items():
        machine = made(seed, lines_only=name != "MJCF")
        path = folder / f"{name.replace(' ', '_')}_{seed}{suffix}"
        loops = "yaml" if "YAML" in name else "loop"
        try:
            found = symkin.load(symkin.convert(machine, path, loops=loops))
            assert_same(as_graph(machine), found)
            assert_same(found, symkin.load(symkin.convert(found, path, loops=loops)))
            yield name, None
        except Exception as error:  # a campaign goes on
            yield name, f"{type(error).__name__}: {' '.join(str(error).split())[:300]}"


def made(seed: int, *, lines_only: bool) -> symkin.Mechanism:
    """A graph, or every fourth time a platform on two to four limbs."""
    if seed % 4:
        return random_graph(seed, lines_only=lines_only)
    rng = np.random.default_rng(seed)
    return random_mechanism(rng, [str(kind) for kind in rng.choice(LIMBS, int(rng.integers(2, 5)))])


if __name__ == "__main__":
    sys.exit(main())
