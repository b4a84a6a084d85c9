"""The rank of a closure at generic configurations of the assembly that its file describes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symkin.computed_once import lru_cache
from symkin.numeric.rank import Rank
from symkin.numeric.rank import generic as generic_one
from symkin.numeric.tolerances import FILE_DIGITS
from symkin.position.closed_configurations import (
    Assembly,
    least_squares_ends,
    own_component,
)
from symkin.position.file_digits import BLUR, ToDigits, rank_to_digits
from symkin.position.own_component import Component
from symkin.text import counted


@dataclass(frozen=True, eq=False)
class GenericRank:
    """A generic configuration and the rank there. `closed`: loops close exactly somewhere; `digits`
    is set where they close only to the digits of a file. `infinitesimal` freedoms of first order
    are followed by no motion; `other_ranks` are those of other branches that meet at the reference,
    `ranks_apart` of other assemblies of the same links.
    """

    values: np.ndarray
    rank: Rank
    closed: bool = True
    digits: ToDigits | None = None
    infinitesimal: int = 0
    other_ranks: tuple[int, ...] = ()
    ranks_apart: tuple[int, ...] = ()

    @property
    def above(self) -> int:
        """How much more the rank to digits is than that here, where nothing beside it closes."""
        digits = self.digits
        return 0 if digits is None or digits.at_reference is None else digits.rank - self.rank.value


def first_order_sentences(freedoms: int, infinitesimal: int) -> list[str]:
    """What is said of freedoms of first order that no motion follows, of all of them."""
    if not infinitesimal:
        return []
    if infinitesimal == freedoms:
        freedom = counted(freedoms, "freedom")
        return [f"no motion leads away from the reference: it is shaky in {freedom} of first order"]
    return [
        f"{infinitesimal} of {freedoms} freedoms of first order "
        f"{'is' if infinitesimal == 1 else 'are'} no motion: every configuration of this assembly "
        f"is singular"
    ]


@lru_cache(maxsize=128)
def generic_rank(assembly: Assembly, seed: int) -> GenericRank:
    """The rank around the reference, or around the closed configuration next to it; `seed` is that
    of the directions in which steps lead away.
    """
    own = own_component(assembly, seed)
    return _by_least_squares(assembly) if own is None else _of_component(assembly, own)


def _of_component(assembly: Assembly, own: Component) -> GenericRank:
    """The assembly that the reference belongs to. Least squares from far off is asked where
    singular values are small everywhere, or no motion leads away, as of loops that close to a
    file's digits; and for other assemblies.
    """
    system = assembly.system
    small = all(
        Rank.of(jacobian, BLUR * FILE_DIGITS).value < own.rank.value
        for jacobian in system.linearise(own.points)[1]
    )
    digits = None
    if small or (own.infinitesimal and len(own.points) == 1):
        digits = rank_to_digits(system, least_squares_ends(assembly, 0), own.rank.value)
    apart = (
        tuple(v for v in _ranks_apart(assembly) if v not in (own.rank.value, *own.other_ranks))
        if digits is None
        else ()
    )
    return GenericRank(
        own.points[0],
        own.rank,
        True,
        digits,
        own.infinitesimal if digits is None else 0,
        own.other_ranks,
        apart,
    )


def _by_least_squares(assembly: Assembly) -> GenericRank:
    """Where least squares ends, of a reference that is open and near to no closed configuration."""
    system, ends = assembly.system, least_squares_ends(assembly, 0)
    candidates = [*ends.points[ends.closed]] or [assembly.reference]
    ranks = [Rank.of(system.linearise_one(z)[1]) for z in candidates]
    best, closed = generic_one(ranks), bool(ends.closed.any())
    digits = rank_to_digits(system, ends, ranks[best].value if closed else None)
    values = (
        candidates[best] if closed or digits is None else ends.points[int(np.argmin(ends.misfits))]
    )
    return GenericRank(values, ranks[best], closed, digits)


def _ranks_apart(assembly: Assembly) -> tuple[int, ...]:
    """Ranks that are clear at two closed configurations or more, wherever least squares from far
    off ends; of seed 0, so that what is said does not depend on the seed.
    """
    system, ends = assembly.system, least_squares_ends(assembly, 0)
    jacobians = system.linearise(ends.points[ends.closed])[1]
    clear = [rank.value for rank in map(Rank.of, jacobians) if rank.is_clear]
    return tuple(sorted({value for value in clear if clear.count(value) > 1}))
