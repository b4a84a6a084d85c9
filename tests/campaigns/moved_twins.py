"""The same machine turned, scaled, and written in another order: are its modes those at home?

    python tests/campaigns/moved_twins.py [--random 200] [--seed 0] [--turns 5] [--only NAME ...]

Every shipped machine and random graphs, at one input with a mode (direct by the actuated joints,
and of limbs also inverse), against twins: each turned by one of some rotations, at sizes from 1e-8
to 1e6, its parts in another order. The count of modes, the complex count, the statement and the
angles of the modes must be those at home. Machines whose declared motion belongs to the base frame
are turned about z only (planar, schoenflies). Exit status 1 where a twin differs.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import symkin
from campaigns.random_graphs import Drawing, chosen_values
from helpers.inside import build_problem, displaced, scaled
from helpers.moved_mechanisms import reordered, scaled_values
from symkin import shipped_names

SIZES = (1e-8, 1e-5, 1e-3, 1e3, 1e6)
"""Factors of all lengths."""
ABOUT_Z = ("planar", "schoenflies")
"""Motions whose turn is about the base frame's z axis."""
SAME = 1e-5
"""Largest difference of an angle (rad) of one mode in both machines."""
Found = symkin.Modes


@dataclass(frozen=True)
class Case:
    """A machine with an input: values of joints by name, or a pose of its platform."""

    mechanism: symkin.Mechanism
    values: Mapping[str, float] | None
    pose: symkin.Pose | None = None

    @property
    def label(self) -> str:
        return f"{self.mechanism.name} {'inverse' if self.pose is not None else 'given'}"

    def modes(self) -> Found:
        m = self.mechanism
        if self.pose is not None:
            return symkin.modes(m, pose=self.pose)
        assert self.values is not None
        if m.is_graph:
            return symkin.modes(m, given=self.values)
        return symkin.modes(m, joints=[self.values[c.name] for c in m.actuated])


def twin(case: Case, by: symkin.Pose, factor: float, order: int) -> Case:
    """The case turned by `by`, then scaled, with its parts in another order."""
    moved = reordered(scaled(displaced(case.mechanism, by), factor), order)
    values = None if case.values is None else scaled_values(case.mechanism, case.values, factor)
    pose = None if case.pose is None else by @ case.pose
    if pose is not None:
        pose = symkin.Pose(factor * np.array(pose.position), pose.quaternion)
    return Case(moved, values, pose)


def turn_of(mechanism: symkin.Mechanism, rng: np.random.Generator) -> symkin.Pose:
    """A rotation that the mechanism's declared motion allows."""
    q = rng.normal(size=4)
    if mechanism.motion in ABOUT_Z:
        q[1:3] = 0.0
    return symkin.Pose.from_quaternion((0.0, 0.0, 0.0), tuple(q / np.linalg.norm(q)))


def difference(home: Found, other: Found, mechanism: symkin.Mechanism) -> str | None:
    """In what two lists differ."""
    told = [(len(f), f.complex_count, f.completeness) for f in (home, other)]
    if told[0] != told[1]:
        return f"{told[1]} for {told[0]}"
    names = [c.name for c in mechanism.coordinates if c.kind == "angle"]
    turn = 2 * np.pi / (360.0 if mechanism.angle_unit == "deg" else 2 * np.pi)
    a, b = (
        np.array([[m.joints[n] for n in names if n in m.joints] for m in f], dtype=float) * turn
        for f in (home, other)
    )
    if (
        a.size
        and np.max(
            np.min(np.max(np.abs(np.angle(np.exp(1j * (a[:, None] - b[None])))), axis=2), axis=1)
        )
        > SAME
    ):
        return "other angles"
    return None


def shipped_cases(only: list[str] | None) -> Iterator[Case]:
    for name in only or shipped_names():
        mechanism = symkin.load(name)
        problem = build_problem(mechanism, "direct") if not mechanism.is_graph else None
        actuated = {
            c.name: mechanism.angle_out(c.reference[0]) if c.is_angular else c.reference[0]
            for c in mechanism.actuated
        }
        if actuated and not (problem is not None and problem.is_explicit):
            yield Case(
                mechanism,
                {
                    name: value + 1e-3 * k
                    for k, (name, value) in enumerate(actuated.items(), start=1)
                },
            )
        if problem is not None:
            found = symkin.solve(mechanism, joints=list(actuated.values()))
            assert found.solution is not None
            yield Case(mechanism, None, found.solution.pose)


def random_cases(count: int, seed: int) -> Iterator[Case]:
    folder, made, index = Path(tempfile.mkdtemp(prefix="moved_twins_")), 0, 0
    while made < count:
        rng = np.random.default_rng([seed, index])
        index += 1
        drawing, path = Drawing(rng), folder / f"{index}.toml"
        path.write_text(drawing.grow())
        chosen = chosen_values(path, rng)
        if chosen is not None:
            made += 1
            yield Case(symkin.load(path), chosen[0])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--random", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--skip", nargs="*", default=[])
    options = parser.parse_args()
    counts: Counter[str] = Counter()
    rng = np.random.default_rng(options.seed)
    for case in chain(
        shipped_cases(options.only),
        random_cases(0 if options.only else options.random, options.seed),
    ):
        if case.mechanism.name in options.skip:
            continue
        begin, findings = time.perf_counter(), []
        try:
            home = case.modes()
            for k in range(options.turns):
                other = twin(case, turn_of(case.mechanism, rng), SIZES[k % len(SIZES)], k)
                text = difference(home, other.modes(), case.mechanism)
                counts["twins"] += 1
                findings += [] if text is None else [f"size {SIZES[k % len(SIZES)]:g}: {text}"]
        except symkin.SymkinError as error:
            findings.append(f"refused: {error}")
        except Exception as error:
            findings.append(f"error: {error!r}")
        counts["differ"] += len(findings)
        print(
            case.label,
            f"{time.perf_counter() - begin:.1f} s",
            "; ".join(findings) or "same",
            flush=True,
        )
    print(dict(counts))
    return int(bool(counts["differ"]))


if __name__ == "__main__":
    sys.exit(main())
