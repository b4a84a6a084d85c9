"""Rank and mobility of a mechanism at closed configurations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.computed_once import lru_cache
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import Rank
from symkin.numeric.rank import generic as generic_one
from symkin.numeric.system import System
from symkin.numeric.tolerances import CLOSED_CONFIGURATION, CLOSURE_TOLERANCE
from symkin.position.closed_configurations import LeastSquaresEnds, least_squares_ends, whole_system
from symkin.position.gruebler import gruebler_kutzbach
from symkin.position.limb_screws import limb_screws, per_freedom, platform_screws
from symkin.position.loops import loops_at, redundant_constraints
from symkin.position.mobility_result import FILE_DIGITS, Misfit, Mobility, ToDigits

_CLEAR_DROP = 2e-2
"""Of the smallest singular value that counts: what the next one has at most where a rank to the digits of a file is clear."""
_BLUR = 30.0
"""Singular values that are zero but for a misfit, over it (a share of the size): what loops are larger than their shortest links."""


def mobility(mechanism: Mechanism, *, seed: int = 0) -> Mobility:
    """Count the freedoms of a mechanism: rank of the closure at generic closed configurations near its reference.

    mobility = freedoms of all coordinates - rank of dF / d(q, x, X) (the singular values below 1e-8 of the largest count as
    zero). Constraint wrenches of the limbs and the platform's twists, reciprocal to them, are those at the reference where its
    rank is the generic one, else at a configuration beside it. `seed` is that of the random steps off the reference. Raises
    MechanismError for what is no Mechanism. Screws: Hunt, Kinematic Geometry of Mechanisms, 1978.

    >>> import symkin
    >>> found = symkin.mobility(symkin.load("zhao2000"))
    >>> found.mobility, found.redundant, found.gruebler
    (4, 4, 1)
    """
    closure = build_closure(mechanism)
    system, nothing, size = whole_system(closure), np.zeros(0), closure.characteristic_length
    reference, ends = closure.reference, least_squares_ends(closure, seed)
    candidates = [*ends.points[ends.closed]] or [reference]
    ranks = [Rank.of(system.linearise_one(z, nothing)[1]) for z in candidates]
    best = generic_one(ranks)
    generic, there = ranks[best], candidates[best]
    reference_rank = None
    if system.residual(reference, nothing) <= CLOSURE_TOLERANCE * size:
        reference_rank = Rank.of(system.linearise_one(reference, nothing)[1])
    closed = reference_rank is not None or bool(ends.closed.any())
    digits = rank_to_digits(system, ends, generic.value if closed else None)
    values = there if closed or digits is None else ends.points[int(np.argmin(ends.misfits))]
    limbs = limb_screws(closure, values)
    at_reference = reference_rank is not None and reference_rank.value == generic.value
    if at_reference:
        at_rest = limb_screws(closure, reference)
        at_reference = [s.counts for s in at_rest] == [s.counts for s in limbs]
        limbs, values = (at_rest, reference) if at_reference else (limbs, values)
    constraints, twists = platform_screws(closure, system, values, limbs)
    unknown = [k for k, c in enumerate(per_freedom(closure.coordinates)) if c.role != "actuated"]
    return Mobility(
        closure=closure,
        values=values,
        at_reference=at_reference,
        closed=closed,
        freedoms=system.freedom,
        rows=_count_rows(closure),
        rank=generic,
        redundant=_redundant(closure, there, generic.value),
        direct_rank=Rank.of(system.linearise_one(there, nothing)[1][:, unknown]),
        limbs=limbs,
        platform_constraints=constraints,
        platform_twists=twists,
        gruebler=gruebler_kutzbach(mechanism),
        reference_rank=reference_rank,
        digits=digits,
        other_ranks=_other_ranks(ranks, generic),
        misfit=None if closed or digits is not None else _misfit(closure, system, ends),
    )


def _other_ranks(ranks: Sequence[Rank], generic: Rank) -> tuple[int, ...]:
    """Smaller ranks that are as clear as the generic one at two closed configurations or more: those of other branches."""
    clear = [rank.value for rank in ranks if rank.is_clear and rank.value < generic.value]
    return tuple(sorted({value for value in clear if clear.count(value) > 1}))


def _redundant(closure: Closure, values: np.ndarray, rank: int) -> int:
    """Redundant constraints of the machine in space: a declared motion leaves rows out, or says what
    they say, so that they are counted by the loops."""
    if closure.mechanism.motion != "spatial":
        return redundant_constraints(closure, values)
    return _count_rows(closure) - rank


def _count_rows(closure: Closure) -> int:
    """Rows of the closure, with those that vanish everywhere, unless the motion declared of a floating platform is why they do."""
    declared = closure.mechanism.motion != "spatial" and closure.role("pose")
    return int(closure.rows.shape[0]) + (0 if declared else closure.vanishing)


@lru_cache(maxsize=64)
def open_loops_note(mechanism: Mechanism) -> str | None:
    """What is said of a mechanism that has no solution, whatever is given: how far its loops stay open, and which; else None."""
    closure = build_closure(mechanism)
    size = closure.characteristic_length
    if whole_system(closure).residual(closure.reference, np.zeros(0)) <= CLOSURE_TOLERANCE * size:
        return None
    misfit = mobility(mechanism).misfit
    if misfit is None:
        return None
    return (
        f"no configuration closes the loops, whatever is given: the best one found leaves {misfit.length:.3g} {mechanism.length_unit}, "
        f"most of it in the loop of {misfit.loop}; check its lengths and couplings"
    )


def rank_to_digits(system: System, ends: LeastSquaresEnds, rank: int | None) -> ToDigits | None:
    """What holds at ends that close the loops only to the digits of a file, where more moves there than exactly (`rank`), or where
    nothing closes exactly, or nothing but a singular reference, at which more moves than beside it."""
    size, misfits = system.characteristic_length, ends.misfits
    near = np.flatnonzero((misfits > CLOSED_CONFIGURATION * size) & (misfits <= FILE_DIGITS * size))
    if not near.size:
        return None
    _, jacobians = system.linearise(ends.points[near], np.zeros(0))
    values = np.linalg.svd(jacobians, compute_uv=False)
    zero = np.maximum(FILE_DIGITS, _BLUR * misfits[near] / size)[:, None] * values[:, :1]
    counts = np.sum(values > zero, axis=1)
    found, misfit = int(np.median(counts)), float(misfits[near].max())
    if rank is None or found < rank:
        return ToDigits(misfit, found)
    clear = [] if ends.closed.any() else _clear(values, counts)
    found = max(set(clear), key=clear.count, default=rank)
    return ToDigits(misfit, found, beside_alone=True) if found > rank else None


def _clear(values: np.ndarray, counts: np.ndarray) -> list[int]:
    """The ranks of those configurations at which the singular values that count are far from those that do not."""
    padded = np.hstack([values, np.zeros((len(values), 1))])
    rows = np.arange(len(values))
    dropped, kept = padded[rows, counts], padded[rows, np.maximum(counts - 1, 0)]
    return [int(count) for count in counts[dropped <= _CLEAR_DROP * kept]]


def _misfit(closure: Closure, system: System, ends: LeastSquaresEnds) -> Misfit:
    """The least of the misfits, and the smallest loop through the joint or rod whose row has most of it."""
    points = np.vstack([closure.reference, ends.points])
    errors = np.concatenate([system.residuals(closure.reference[None], np.zeros(0)), ends.misfits])
    best = int(np.argmin(errors))
    rows, _ = system.linearise_one(points[best], np.zeros(0))
    worst = closure.row_sources[int(np.argmax(np.abs(rows)))].limb
    loops = [loop for loop in loops_at(closure, points[best]) if worst in loop.joints]
    return Misfit(float(errors[best]), min(loops, key=lambda loop: len(loop.joints)).name if loops else worst)
