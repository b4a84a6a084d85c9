"""What the velocity equations say of one configuration: singular or not, which kind, how near, and
the screws that show it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.position.solution import Solution
from symkin.result import Result, Summary, json_fields, json_value
from symkin.singularities.named_screw import NamedScrew
from symkin.singularities.output import Output
from symkin.singularities.singular_groups import SingularGroup
from symkin.text import counted, plain
from symkin.velocity.limb_equations import LimbwiseEquations, Ranks
from symkin.velocity.roles import Roles

_INCREASED = "the loops' constraints lose rank: the mechanism has more freedoms than elsewhere"
_CONSTRAINT = "the limbs' constraint wrenches lose rank: the platform gains a freedom"
KINDS = {
    "type 1": "the inverse problem loses rank: joints move, the platform stands",
    "type 2": "the direct problem loses rank: the platform moves, the actuated joints stand",
    "increased": _INCREASED,
    "constraint": _CONSTRAINT,
    "passive": "passive joints move alone, platform and actuated joints stand",
}
"""Kinds of singularity and what they mean."""
OUTPUT_KINDS = {
    "type 1": "the inverse problem loses rank: joints move, the output stands",
    "type 2": "the direct problem loses rank: the output moves, the actuated joints stand",
    "increased": _INCREASED,
    "constraint": _CONSTRAINT,
    "passive": "platform or passive joints move, output and actuated joints stand",
}
"""What the kinds mean where an output is named."""
GIVEN_KINDS = {
    "type 1": "the given coordinates move, {output} stands",
    "type 2": "{output} may move, the given coordinates stand",
    "increased": _INCREASED,
    "constraint": _CONSTRAINT,
    "passive": "further joints may move alone, the given coordinates and {output} stand",
}
"""What the kinds mean where coordinates drive that are told by name."""
CONDITIONS = {
    "RI": "redundant input",
    "RO": "redundant output",
    "II": "impossible input",
    "IO": "impossible output",
    "RPM": "redundant passive motion",
    "IIM": "increased instantaneous mobility",
}
"""Zlatanov's conditions in words."""


@dataclass(frozen=True, eq=False, repr=False)
class Singularity(Result):
    """What the velocity equations A t + B q' = 0 say at one configuration; made by
    `symkin.singularity`.

    `kinds` are keys of KINDS, `conditions` Zlatanov's names: what differs here from a generic
    configuration of the same mechanism, both empty where nothing does. Such a configuration is
    regular only where `uncontrolled_freedoms`, the platform's freedoms that the actuated joints
    leave at every configuration when they are held, is 0. `distances` holds, for each kind that the
    mechanism can have, the smallest singular value (of those that are not zero everywhere) of its
    matrix with rows of unit length, angles times the size: the 2-norm of the smallest change of
    these rows that makes the configuration singular, between 0 and 1 for each limb (Voglewede and
    Ebert-Uphoff 2005 compare such measures). They depend on the platform origin, and on neither
    units nor the base frame.

    `singular_values` are those of the direct map q' -> t (lengths; angles times the size),
    `manipulability` their product (Yoshikawa 1985), infinite where the platform moves with the
    actuated joints held (type 2, or `uncontrolled_freedoms`). `twists` are these motions, or those
    with all joints free where a constraint is lost; `wrenches` what the platform bears without the
    actuated joints' help where an output is impossible; `inputs` the joint rates with the platform
    at rest (type 1), in the mechanism's units, the largest 1; `feasible_twists` span what the
    platform can do. Where an `output` is named, it stands for the twist in all of this: `equations`
    and `ranks` (here and `generic`) are those reduced to it.

    Where coordinates that are told by name drive (`given`), `motions` are independent motions while
    they stand, as rates of joints in the mechanism's units, the largest 1, `groups` the structure
    groups that are singular, and `rank_loss` counts the motions that other configurations do not
    have.

    >>> import symkin
    >>> quarter_turn = [0.5**0.5, 0, 0, 0.5**0.5]
    >>> found = symkin.singularity(symkin.load("zhang2009"), pose=[0, 0, 300, *quarter_turn])
    >>> found.kinds, found.conditions
    (('type 2',), ('RO', 'II'))
    """

    solution: Solution
    equations: LimbwiseEquations
    ranks: Ranks
    generic: Ranks
    conditions: tuple[str, ...]
    kinds: tuple[str, ...]
    distances: dict[str, float]
    singular_values: np.ndarray
    twists: tuple[NamedScrew, ...]
    wrenches: tuple[NamedScrew, ...]
    inputs: tuple[dict[str, float], ...]
    feasible_twists: tuple[NamedScrew, ...]
    roles: Roles
    notes: tuple[str, ...] = ()
    output: Output | None = None
    motions: tuple[dict[str, float], ...] = ()
    groups: tuple[SingularGroup, ...] = ()

    @property
    def given(self) -> tuple[str, ...]:
        """The coordinates that drive, where they are told by name."""
        return self.roles.inputs if self.roles.by_name else ()

    @property
    def rank_loss(self) -> int:
        """Motions with the inputs held, beyond those that every configuration has."""
        here, elsewhere = (r.idle - r.twist for r in (self.ranks, self.generic))
        return here - elsewhere

    @property
    def permanent_freedoms(self) -> dict[str, int]:
        """Freedoms of each kind that every configuration has, where there are any; kinds and
        distances count further ones.
        """
        return self.generic.permanent_freedoms

    @property
    def uncontrolled_freedoms(self) -> int:
        """Freedoms that the platform has at every configuration with all actuated joints held."""
        return self.permanent_freedoms.get("type 2", 0)

    @property
    def is_singular(self) -> bool:
        """Whether the platform or some joints move more freely than the actuated joints say, here
        or everywhere.
        """
        return bool(self.kinds) or self.uncontrolled_freedoms > 0

    @property
    def distance(self) -> float:
        """The smallest of the distances."""
        return min(self.distances.values(), default=float("inf"))

    @property
    def manipulability(self) -> float:
        """Product of the direct map's singular values; that of the inverse map is its
        reciprocal.
        """
        return float(np.prod(self.singular_values))

    @property
    def inverse_manipulability(self) -> float:
        """Product of the inverse map's singular values."""
        value = self.manipulability
        return float("inf") if value == 0.0 else 1.0 / value

    @property
    def condition(self) -> float:
        """Largest over smallest singular value of the direct map, and of the inverse one."""
        s = self.singular_values
        return float(s[0] / s[-1]) if s.size and np.isfinite(s[0]) and s[-1] > 0.0 else float("inf")

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `symkin singularities`; infinite numbers are None."""
        mechanism = self.solution.mechanism
        return {
            "mechanism": mechanism.name,
            "length_unit": mechanism.length_unit,
            "angle_unit": mechanism.angle_unit,
            "size": mechanism.characteristic_length,
            "output": self._output_dict(),
            "configuration": self.solution.to_dict(),
            **json_fields(self, "kinds", "conditions"),
            "everywhere": self.permanent_freedoms,
            "distances": dict(self.distances),
            **{
                name: _finite(getattr(self, name))
                for name in ("condition", "manipulability", "inverse_manipulability")
            },
            "singular_values": [_finite(float(value)) for value in self.singular_values],
            **json_fields(self, "twists", "wrenches", "inputs"),
            **(
                json_fields(self, "given", "rank_loss", "motions")
                | {"blocks": json_value(self.groups)}
                if self.given
                else {}
            ),
            **json_fields(self, "notes"),
        }

    def _output_dict(self) -> dict[str, Any] | None:
        if self.output is not None:
            return self.output.to_dict()
        named = () if self.roles.has_twist else self.roles.outputs
        return {"coordinates": list(named), "point": None} if named else None

    def summary(self, most_rows: int | None = None) -> Summary:  # noqa: ARG002 - there is no table
        """Kind and conditions, distances, condition and manipulability, then the screws and joint
        rates that show it.
        """
        free = "constraint" in self.kinds and "type 2" not in self.kinds
        driven = "given coordinates" if self.given else "actuated joints"
        held = f"with the {driven} free" if free else f"with the {driven} held"
        lines = [
            str(self.solution),
            *self._head_lines(),
            self._distance_line(),
            self._map_line(),
        ]
        lines += [f"platform motion {held}: {screw}" for screw in self.twists]
        lines += [f"borne without the {driven}: {screw}" for screw in self.wrenches]
        lines += [
            f"joint rates with the {driven} held: {_rates(rates)}"
            for rates in self.motions
            if self.rank_loss
        ]
        lines += [f"singular: {group}" for group in self.groups]
        lines += [
            f"joint rates with the {self._moving} at rest: {_rates(rates)}" for rates in self.inputs
        ]
        return Summary([*lines, *(f"note: {note}" for note in (*self.solution.notes, *self.notes))])

    @property
    def _moving(self) -> str:
        named = self.roles.outputs is not None and not self.roles.has_twist
        return "output" if self.output is not None or named else "platform"

    def _head_lines(self) -> list[str]:
        """The output, what drives or is never decided, and the kinds with their meanings."""
        lines = [] if self.output is None else [f"output: velocity {self.output}"]
        meanings, output = KINDS if self.output is None else OUTPUT_KINDS, "the output"
        regular, count = "regular", self.uncontrolled_freedoms
        everywhere = f"with all actuated joints held the {self._moving} keeps"
        if self.given:
            meanings = GIVEN_KINDS
            output = self.roles.output_text if self.output is None else output
            lines.append(f"driven by: {', '.join(self.given)}; wanted: {output}")
            everywhere = "the given coordinates leave"
        if count:
            regular = "no further singularity"
            lines.append(
                f"singular everywhere: {everywhere} {counted(count, 'freedom')} at every "
                f"configuration"
            )
        head = ", ".join(self.kinds) + " singularity" if self.kinds else regular
        if self.given and self.rank_loss:
            head += (
                f", {self.rank_loss} further motion{'s' * (self.rank_loss > 1)} with the given "
                f"coordinates held"
            )
        if self.conditions:
            head += f" ({', '.join(CONDITIONS[name] for name in self.conditions)})"
        told = [f"  {kind}: {meanings[kind].format(output=output)}" for kind in self.kinds]
        return [*lines, head, *told]

    def _distance_line(self) -> str:
        counts = self.permanent_freedoms
        beyond = {
            kind: f" (from more than the {count} everywhere)" for kind, count in counts.items()
        }
        distances = ", ".join(
            f"{kind} {plain(value):.3g}{beyond.get(kind, '')}"
            for kind, value in self.distances.items()
        )
        size = self.solution.mechanism.characteristic_length
        return (
            f"distance (0 singular; rows of unit length, angles times the size {size:.6g}): "
            f"{distances}"
        )

    def _map_line(self) -> str:
        wanted = "output" if self.output is not None or not self.roles.has_twist else "twist"
        return (
            f"direct map, {'given' if self.given else 'joint'} rates to {wanted}: condition "
            f"{self.condition:.4g}, "
            f"manipulability {self.manipulability:.4g}; inverse map "
            f"{self.inverse_manipulability:.4g}"
        )


def _rates(rates: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.6g}" for name, value in rates.items())


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
