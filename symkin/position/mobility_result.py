"""What is said of a mechanism's mobility: the result of `mobility`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import cached_property
from symkin.numeric.rank import Rank
from symkin.numeric.tolerances import CLEAR_GAP, FILE_DIGITS, RANK_TOLERANCE
from symkin.position.file_digits import ToDigits
from symkin.position.generic_rank import first_order_sentences
from symkin.position.gruebler import counts
from symkin.position.limb_screws import LimbScrews, in_space
from symkin.position.loops import Loop, loops_at
from symkin.result import Result, Summary
from symkin.text import counted


@dataclass(frozen=True)
class Misfit:
    """How far loops stay open: the largest closure error at the best configuration found, and the
    loop that has it.
    """

    length: float
    loop: str


@dataclass(frozen=True, eq=False, repr=False)
class Mobility(Result):
    """What the closure's differential says at one closed configuration.

    mobility = freedoms of all coordinates - rank - `infinitesimal`, freedoms of first order that no
    motion follows. `redundant` counts the constraints of the machine in space that others imply,
    whatever motion is declared; without a declared motion it is rows - rank, rows that vanish at
    every configuration included. `values` are the closure's variables there; `at_reference` says
    that it is the reference configuration, `reference_rank` is the rank there, None where it is
    open. `platform_constraints` spans the wrenches of all limbs together and `platform_twists` the
    instantaneous platform motions reciprocal to them (rows, base origin). `digits` is set where
    they close only to the digits of the file, `misfit` where they do not close at all.
    `other_ranks` are those of other branches that meet at the reference, `ranks_apart` of other
    assemblies of the same links. `gruebler` is the Gruebler-Kutzbach count, which knows nothing of
    geometry and counts idle freedoms.

    >>> import symkin
    >>> found = symkin.mobility(symkin.load("zhao2000_links"))
    >>> [limb.counts for limb in found.limbs], len(found.platform_constraints)
    ([(1, 2), (1, 2), (1, 2), (0, 1)], 2)
    """

    closure: Closure
    values: np.ndarray
    at_reference: bool
    closed: bool
    freedoms: int
    rows: int
    rank: Rank
    redundant: int
    direct_rank: Rank
    limbs: tuple[LimbScrews, ...]
    platform_constraints: np.ndarray
    platform_twists: np.ndarray
    gruebler: int
    reference_rank: Rank | None = None
    digits: ToDigits | None = None
    other_ranks: tuple[int, ...] = ()
    misfit: Misfit | None = None
    infinitesimal: int = 0
    ranks_apart: tuple[int, ...] = ()

    @cached_property
    def loops(self) -> tuple[Loop, ...]:
        """The independent loops, each with its own rank."""
        return loops_at(
            self.closure, self.values, RANK_TOLERANCE if self.digits is None else FILE_DIGITS
        )

    @property
    def mobility(self) -> int:
        """Freedoms that the loops leave."""
        return self.freedoms - self.rank.value - self.infinitesimal

    @property
    def implied_rows(self) -> int:
        """Rows of the closure that the others imply, under the motion that is declared."""
        return self.rows - self.rank.value

    @property
    def redundant_at_reference(self) -> int | None:
        """Redundant constraints of the machine at the reference; None where it is open."""
        if self.reference_rank is None:
            return None
        return redundant_constraints(
            self.closure, self.closure.reference, self.reference_rank.value
        )

    def redundant_of(self, rank: int) -> int:
        """Redundant constraints where the closure has another rank."""
        return self.redundant + self.rank.value - rank

    @property
    def actuated(self) -> int:
        """Count of actuated joints."""
        return len(self.closure.mechanism.actuated)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is doubtful: an unclear rank, actuated joints that are not as many as the mobility
        or do not decide it.
        """
        found = [*self._closing]
        if self.rank.gap < CLEAR_GAP:
            found.append(
                f"the rank is not clear, the singular values beside the cut differ by only "
                f"{self.rank.gap:.3g}"
            )
        if self.misfit is not None:
            return tuple(found)
        if len(self._beyond_motion):
            screws = ", ".join(
                "(" + ", ".join(f"{v + 0.0:.5g}" for v in twist) + ")"
                for twist in self._beyond_motion
            )
            found.append(
                f"the platform's motion is declared {self.closure.mechanism.motion}, and its "
                f"joints let it move otherwise too (twists, angular "
                f"velocity first: {screws})"
            )
        if self.digits is None:
            found += self._beside
        mobility = self.mobility if self.digits is None else self.freedoms - self.digits.rank
        if self.actuated != mobility:
            more = (
                "some motion stays free"
                if self.actuated < mobility
                else "the inputs cannot be chosen freely"
            )
            found.append(
                f"{counted(self.actuated, 'actuated joint')} for a mobility of {mobility}: {more}"
            )
        elif (
            self.digits is None
            and not self.infinitesimal
            and self.direct_rank.value < self.freedoms - self.actuated
        ):
            found.append(
                "the actuated joints do not determine the configuration, although their number is "
                "the mobility"
            )
        return tuple(found)

    @property
    def _beside(self) -> list[str]:
        """What is said of motions that end at once, of branches that meet and of other
        assemblies.
        """
        found = first_order_sentences(self.freedoms - self.rank.value, self.infinitesimal)
        if self.other_ranks:
            found.append(
                f"branches meet near the reference: closed configurations beside it have a "
                f"mobility of {self._mobilities(self.other_ranks)} "
                "too; what is said here is of one branch, and a declared motion or another "
                "reference chooses"
            )
        if self.ranks_apart:
            found.append(
                f"other assemblies of the same links have a mobility of "
                f"{self._mobilities(self.ranks_apart)}; what is said here is of the "
                "one that the reference belongs to"
            )
        return found

    def _mobilities(self, ranks: tuple[int, ...]) -> str:
        return " and ".join(str(self.freedoms - rank) for rank in ranks)

    @property
    def _beyond_motion(self) -> np.ndarray:
        """Of the twists that the joints leave the platform those that the motion declared of it
        does not have, as rows.
        """
        mechanism, twists = self.closure.mechanism, self.platform_twists
        if mechanism.motion == "spatial" or not len(twists):
            return np.zeros((0, 6))
        size = self.closure.characteristic_length
        turns, speeds = twists[:, :3], twists[:, 3:] / size
        if mechanism.motion == "spherical":
            outside = speeds + np.cross(turns, np.asarray(mechanism.reference_pose.position) / size)
        elif mechanism.motion == "translation":
            outside = turns
        else:
            outside = np.hstack(
                [turns[:, :2], speeds[:, 2:] if mechanism.motion == "planar" else speeds[:, :0]]
            )
        largest = np.linalg.norm(np.hstack([turns, speeds]), axis=1)
        return twists[np.linalg.norm(outside, axis=1) > RANK_TOLERANCE * largest]

    @property
    def _closing(self) -> tuple[str, ...]:
        """What is said of loops that do not close, or not exactly."""
        unit = self.closure.mechanism.length_unit
        if self.misfit is not None:
            return (
                f"no configuration closes the loops: the best one found leaves "
                f"{self.misfit.length:.3g} {unit}, most of it in the loop "
                f"of {self.misfit.loop}; what is said here holds at the open reference",
            )
        if self.digits is None:
            return ()
        rank = self.digits.rank
        where, exactly = (
            ("away from the reference ", f"; exactly, it is {self.mobility}")
            if self.closed
            else ("", "")
        )
        if self.digits.at_reference is not None:
            exactly = (
                "; at the reference, which is singular, it is "
                f"{self.freedoms - self.digits.at_reference}"
            )
        return (
            f"{where}the loops close only to the digits of the file: least-squares configurations "
            f"leave {self.digits.misfit:.1e} "
            f"{unit}; to these digits the mobility is {self.freedoms - rank}, with "
            f"{self.redundant_of(rank)} redundant constraints{exactly}",
        )

    def summary(self, most_rows: int | None = None) -> Summary:
        """Mobility and redundant constraints, then the count of constraint wrenches that each limb
        exerts.
        """
        name, where = (
            self.closure.mechanism.name,
            "" if self.closed else " (no closed configuration was found)",
        )
        less = f" - {self.infinitesimal} of first order alone" if self.infinitesimal else ""
        above = [
            f"{name}: mobility {self.mobility} = {self.freedoms} freedoms of the coordinates - "
            f"rank {self.rank.value} of "
            f"{self.rows} rows{less}; redundant constraints: {self.redundant}{where}"
        ]
        below = [f"warning: {warning}" for warning in self.warnings]
        if not self.limbs:
            cells = [
                [loop.name, str(loop.rows), str(loop.rank), str(loop.redundant)]
                for loop in self.loops
            ]
            return Summary(above, ["loop", "rows", "rank", "redundant"], cells[:most_rows], below)
        rows = [[limb.limb, *map(str, limb.counts)] for limb in self.limbs]
        rows.append(["platform", str(len(self.platform_constraints)), ""])
        header = ["limb", "constraint wrenches", "with actuated joints locked"]
        return Summary(above, header, rows[:most_rows], below)

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of `symkin show --json`; wrenches are (force; moment), twists (angular
        velocity; velocity), about the base origin.
        """
        closure, reference = self.closure, self.reference_rank
        mechanism = closure.mechanism
        links, joints, _ = counts(mechanism)
        return {
            "mechanism": mechanism.name,
            "length_unit": mechanism.length_unit,
            "angle_unit": mechanism.angle_unit,
            "links": links,
            "joints": joints,
            "loops": joints - links + 1,
            "rows": self.rows,
            "rank": None if reference is None else reference.value,
            "mobility": None if reference is None else self.freedoms - reference.value,
            "redundant": self.redundant_at_reference,
            "generic": {
                "rank": self.rank.value,
                "mobility": self.mobility,
                "infinitesimal": self.infinitesimal,
                "redundant": self.redundant,
                "closed": self.closed,
            },
            "gruebler": self.gruebler,
            "actuated": [c.name for c in mechanism.actuated],
            "limbs": [
                {
                    "name": limb.limb,
                    "constraints": limb.constraints.tolist(),
                    "locked": limb.locked.tolist(),
                }
                for limb in self.limbs
            ],
            "platform_constraints": self.platform_constraints.tolist(),
            "platform_twists": self.platform_twists.tolist(),
            "screws_at_reference": self.at_reference,
            "notes": list(self.warnings),
            "rods": len(mechanism.link_rods),
            "couplings": len(mechanism.couplings),
            "each_loop": [
                {
                    "joints": list(loop.joints),
                    "links": list(loop.links),
                    "rows": loop.rows,
                    "rank": loop.rank,
                    "redundant": loop.redundant,
                }
                for loop in self.loops
            ],
            "unknowns": [c.name for c in closure.coordinates if c.role != "actuated"],
            "idle": list(closure.idle),
            "misfit": None if self.misfit is None else self.misfit.length,
            "to_digits": None
            if self.digits is None
            else {
                "misfit": self.digits.misfit,
                "rank": self.digits.rank,
                "mobility": self.freedoms - self.digits.rank,
            },
        }


def count_rows(closure: Closure) -> int:
    """Rows of a closure, with those that vanish everywhere, unless the motion declared of a
    floating platform is why they do.
    """
    declared = closure.mechanism.motion != "spatial" and closure.role("pose")
    return closure.rows.shape[0] + (0 if declared else closure.vanishing)


def redundant_constraints(closure: Closure, values: np.ndarray, rank: int) -> int:
    """Count the constraints of the machine in space that others imply at a configuration where the
    closure has a rank: a declared motion leaves rows out, or says what they say.
    """
    if closure.mechanism.motion == "spatial":
        return count_rows(closure) - rank
    spatial, _, jacobian = in_space(closure, values)
    return count_rows(spatial) - Rank.of(jacobian).value
