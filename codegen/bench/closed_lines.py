"""Is NAME_OK right where formulas solve the direct problem? Many lines, beside folds and far ones,
each looked at in many points.

Guesses are configurations all over the workspace, half of them beside a fold; goals lie up to
`--range` away. The reference walks each line in `--points` points: the discriminants of the closed
form in double precision, with the guess's signs, must be above zero at all of them, and the answer
is the formulas' at the end. `OK` on a line that has a point below zero, or with another pose, is
wrong.

    python codegen/bench/closed_lines.py [NAME|FILE ...] [--count 20000] [--range PART,TURN]
        [--points 400] [--real double] [--seed 0]
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np

from asked import Asked
from goals import Reach
from symkin.codegen.limb_platform import LimbPlatform
from symkin.codegen.options import Options
from symkin.codegen.program import build_program
from symkin.formats.load import load
from symkin.model.mechanism import Mechanism
from symkin.position.solution import pose_of

STUDIED = (
    "delta",
    "zhao2000",
    "zhao2000_links",
    str(Path(__file__).parent / "machines" / "five_bar.toml"),
)
_SHARES = (0.03, 0.1, 0.3, 1.0)
"""Parts of the range within which goals lie."""
_BESIDE = 0.03
"""Share of a discriminant's usual size below which a configuration is beside a fold."""
_CLEAR = 1e-3
"""Share of it above which all points of a line are regular beyond doubt."""
_GRAZED = {"double": 1e-9, "float": 1e-4}
"""Share of it by which a line may leave what is real: rounding of the guess's pose moves the line
by as much.
"""


@dataclass(frozen=True)
class Found:
    """Counts: lines, those that are regular, OK, OK on others or with another pose, and OK of the
    regular ones.
    """

    lines: int
    regular: int
    ok: int
    wrong: int
    good: int

    def row(self, name: str, real: str) -> str:
        return (
            f"| {name} {real} | {self.lines:,} | {self.regular:,} | "
            f"{100 * self.good / max(1, self.regular):.2f} % | {self.ok:,} | {self.wrong} |"
        )


class Reference:
    """The direct problem of a machine by its closed form, many inputs at once."""

    def __init__(self, mechanism: Mechanism) -> None:
        kind = build_program(mechanism, Options("double")).kind
        assert isinstance(kind, LimbPlatform)  # noqa: S101 - what is studied has limbs
        assert kind.direct_formulas is not None  # noqa: S101 - and formulas
        self.kind, self.form = kind, kind.direct_formulas.formulas
        self.problem, self.usual = kind.direct, kind.direct_formulas.usual_roots**2
        form = self.form
        whole = ca.vertcat(form.values, form.discriminants)
        for k in reversed(range(int(form.roots.shape[0]))):
            whole = ca.substitute(
                whole, form.roots[k], ca.sqrt(ca.fmax(form.discriminants[k], 0.0))
            )
        self._function = ca.Function(
            "whole", [form.signs, form.system.known], [whole], {"cse": True}
        )
        self._sides = self._side_function()

    def _side_function(self) -> ca.Function:
        """What tells the sides of the limbs' dead centres, at least 0 on those of the reference, by
        all variables.
        """
        closure, inverse = self.problem.closure, self.kind.inverse
        sides = []
        for block in self.kind.blocks:
            if block.formulas is None:
                continue
            system = block.system
            told = block.formulas.sides(self.kind.home_signs(block.formulas))
            for symbols, coordinates in (
                (system.unknown, system.unknowns),
                (system.known, inverse.known_coordinates),
            ):
                values = ca.vertcat(
                    *(closure.variables[closure.slices[c.name]] for c in coordinates)
                )
                told = ca.substitute(told, symbols, values)
            sides.append(told)
        return ca.Function(
            "sides", [closure.variables], [closure.bound(ca.vertcat(ca.SX(0, 1), *sides))]
        )

    def at(self, signs: np.ndarray, given: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Unknowns (n, width) and discriminants (n, choices) over their usual sizes."""
        found = np.asarray(self._function.map(len(given))(signs.T, given.T)).T
        width = self.form.system.width
        return found[:, :width], found[:, width:] / self.usual

    def variables(self, unknown: np.ndarray, given: np.ndarray) -> np.ndarray:
        return np.array(
            [self.problem.join_values(z, q) for z, q in zip(unknown, given, strict=True)]
        )

    def on_reference_sides(self, unknown: np.ndarray, given: np.ndarray) -> np.ndarray:
        """Whether limbs stand on the reference's sides of their dead centres."""
        values = self.variables(unknown, given)
        told = np.asarray(self._sides.map(len(values))(values.T)).T
        return np.all(told > 0.0, axis=1)

    def least(
        self, signs: np.ndarray, starts: np.ndarray, goals: np.ndarray, points: int
    ) -> np.ndarray:
        """The least discriminant on each line, over its usual size."""
        least = np.full(len(goals), np.inf)
        for part in np.linspace(0.0, 1.0, points):
            _, found = self.at(signs, starts + part * (goals - starts))
            least = np.minimum(least, np.min(np.where(np.isfinite(found), found, -1.0), axis=1))
        return least


def study(
    mechanism: Mechanism, real: str, count: int, reach: Reach, points: int, seed: int
) -> Found:
    reference = Reference(mechanism)
    rng, joints = np.random.default_rng(seed), mechanism.actuated
    size = mechanism.characteristic_length
    spread = np.array([reach.turn if c.is_angular else reach.part * size for c in joints])
    middle = np.array([c.reference[0] for c in joints])
    home = reference.kind.home_values
    problem = reference.problem
    home_signs = reference.form.signs_at(
        problem.select_values(home, problem.system.unknowns),
        problem.select_values(home, problem.known_coordinates),
    )
    starts = middle + spread * rng.uniform(-1, 1, (12 * count, len(joints)))
    signs = np.tile(home_signs, (len(starts), 1))
    unknown, found = reference.at(signs, starts)
    real_ones = np.all(found > _GRAZED[real], axis=1)
    real_ones[real_ones] = reference.on_reference_sides(unknown[real_ones], starts[real_ones])
    beside = real_ones & (np.min(found, axis=1) < _BESIDE)
    chosen = np.concatenate(
        [np.flatnonzero(beside)[: count // 4], np.flatnonzero(real_ones & ~beside)[: count // 2]]
    )
    home_rows = np.zeros(count - len(chosen), dtype=int)
    z_home, q_home = (
        problem.select_values(home, c) for c in (problem.system.unknowns, problem.known_coordinates)
    )
    starts = np.concatenate([starts[chosen], np.tile(q_home, (len(home_rows), 1))])
    unknown = np.concatenate([unknown[chosen], np.tile(z_home, (len(home_rows), 1))])
    signs = np.tile(home_signs, (count, 1))
    goals = starts + rng.choice(_SHARES, (count, 1)) * spread * rng.uniform(-1, 1, starts.shape)
    for i, c in enumerate(joints):
        if c.limits is not None:
            goals[:, i] = np.clip(goals[:, i], *c.limits)
        if c.least is not None:
            goals[:, i] = np.maximum(goals[:, i], c.least + 1e-3 * size)
    goals = goals.astype(np.float32 if real == "float" else np.float64).astype(float)
    # an angle without limits goes the nearer way
    free = np.array([c.kind == "angle" and c.limits is None for c in joints])
    turned = goals - starts
    ends = starts + np.where(free, turned - 2 * np.pi * np.round(turned / (2 * np.pi)), turned)
    guesses = _poses(reference, unknown, starts)
    asked = Asked(mechanism, Options(real)).answers(goals, guesses)  # type: ignore[arg-type]
    status, answers, ok = asked.status, asked.found, asked.status == 0
    least = reference.least(signs, starts, ends, points)
    at_end, _ = reference.at(signs, ends)
    poses = _poses(reference, at_end, ends)
    off = np.max(np.abs(answers[:, :3] - poses[:, :3]), axis=1)
    turn = np.minimum(*(np.max(np.abs(answers[:, 3:] + s * poses[:, 3:]), axis=1) for s in (1, -1)))
    away = np.maximum(off, 2 * size * turn)
    # next to a fold the answer moves by the root of what the joints do
    near = (1e-6 if real == "double" else 2e-3) * size
    wrong = ok & ((least < -_GRAZED[real]) | (away > near))
    sides = np.zeros(count, dtype=bool)
    inside = least > 0.0
    sides[inside] = reference.on_reference_sides(at_end[inside], ends[inside])
    regular = (least > _CLEAR) & sides & (status != 4)
    return Found(
        count, int(regular.sum()), int(ok.sum()), int(wrong.sum()), int((ok & regular).sum())
    )


def _poses(reference: Reference, unknown: np.ndarray, given: np.ndarray) -> np.ndarray:
    """Numbers (n, 7) of poses."""
    closure = reference.problem.closure
    expression = closure.bound(ca.vertcat(closure.pose.position, closure.pose.quaternion))
    function = ca.Function("pose", [closure.variables], [expression], {"cse": True})
    values = reference.variables(unknown, given)
    first = pose_of(closure, values[0])
    found = np.asarray(function.map(len(values))(values.T)).T
    assert np.allclose(found[0, :3], first.position)  # noqa: S101 - one pose, two ways
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0] if __doc__ else "")
    parser.add_argument("names", nargs="*", default=list(STUDIED))
    parser.add_argument(
        "--range",
        metavar="PART,TURN",
        default="0.3,1.5",
        help="how far goals lie: a part of the size, and rad",
    )
    parser.add_argument("--count", type=int, default=20000)
    parser.add_argument("--points", type=int, default=400)
    parser.add_argument(
        "--real", choices=("float", "double"), action="append", help="default: both"
    )
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    print("| solver | lines | regular | OK of these | OK | wrong |\n|---|---|---|---|---|---|")
    for name in chosen.names:
        for real in chosen.real or ["double", "float"]:
            reach = Reach(*(float(number) for number in chosen.range.split(",")))
            print(
                study(load(name), real, chosen.count, reach, chosen.points, chosen.seed).row(
                    Path(name).stem, real
                ),
                flush=True,
            )
