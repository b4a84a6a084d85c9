"""Rank and mobility of a mechanism at closed configurations."""

from __future__ import annotations

import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.computed_once import lru_cache
from symkin.model.mechanism import Mechanism
from symkin.numeric.rank import Rank
from symkin.numeric.system import System
from symkin.numeric.tolerances import CLOSED_CONFIGURATION, CLOSURE_TOLERANCE, RANK_TOLERANCE
from symkin.position.closed_configurations import closed_configurations, least_squares_ends, whole_system
from symkin.position.gruebler import gruebler_kutzbach
from symkin.position.limb_screws import limb_screws, per_freedom, platform_twists, reciprocal_system, row_space
from symkin.position.loops import loops_at
from symkin.position.mobility_result import Misfit, Mobility, ToDigits

_DIGITS = 1e-5
"""Of the size: loops that leave less at least-squares configurations are closed to the digits of a file; and the share of the
largest singular value below which others are zero to these digits. Files are written with five digits and more."""
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
    (4, 0, 1)
    """
    if mechanism.is_graph:
        return _mobility_of_graph(mechanism, seed)
    closure = build_closure(mechanism)
    system = whole_system(closure)
    nothing = np.zeros(0)
    candidates = closed_configurations(closure, seed)
    ranks = [Rank.of(system.linearise_one(z, nothing)[1]) for z in candidates]
    best = max(range(len(ranks)), key=lambda k: ranks[k].value)
    generic = ranks[best]
    reference = closure.reference
    limbs, values = limb_screws(closure, candidates[best]), candidates[best]
    is_closed = system.residual(reference, nothing) <= CLOSURE_TOLERANCE * closure.characteristic_length
    reference_rank = Rank.of(system.linearise_one(reference, nothing)[1]) if is_closed else None
    at_reference = reference_rank is not None and reference_rank.value == generic.value
    if at_reference:
        there = limb_screws(closure, reference)
        at_reference = [s.counts for s in there] == [s.counts for s in limbs]
        limbs, values = (there, reference) if at_reference else (limbs, values)
    constraints = row_space(np.vstack([limb.constraints for limb in limbs]), closure.characteristic_length)
    jacobian = system.linearise_one(candidates[best], nothing)[1]
    unknown = [k for k, c in enumerate(per_freedom(closure.coordinates)) if c.role != "actuated"]
    return Mobility(
        closure=closure,
        values=values,
        at_reference=at_reference,
        closed=system.residual(values, nothing) <= CLOSURE_TOLERANCE * closure.characteristic_length,
        freedoms=system.freedom,
        rows=int(closure.rows.shape[0]),
        rank=generic,
        direct_rank=Rank.of(jacobian[:, unknown]),
        limbs=limbs,
        platform_constraints=constraints,
        platform_twists=row_space(reciprocal_system(constraints, closure.characteristic_length), closure.characteristic_length)
        if len(constraints)
        else np.eye(6),
        gruebler=gruebler_kutzbach(mechanism),
        reference_rank=reference_rank,
    )


@lru_cache(maxsize=64)
def open_loops_note(mechanism: Mechanism) -> str | None:
    """What is said of a graph that has no solution, whatever is given: how far its loops stay open, and which; else None."""
    if not mechanism.is_graph:
        return None
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


def _mobility_of_graph(mechanism: Mechanism, seed: int) -> Mobility:
    closure = build_closure(mechanism)
    system, nothing, size = whole_system(closure), np.zeros(0), closure.characteristic_length
    reference = closure.reference
    is_closed = system.residual(reference, nothing) <= CLOSURE_TOLERANCE * size
    ends = least_squares_ends(closure, seed)
    misfits = system.residuals(ends, nothing)
    candidates = [*ends[misfits <= CLOSED_CONFIGURATION * size]] or [reference]
    ranks = [Rank.of(system.linearise_one(z, nothing)[1]) for z in candidates]
    best = max(range(len(ranks)), key=lambda k: ranks[k].value)
    generic, values = ranks[best], candidates[best]
    reference_rank = Rank.of(system.linearise_one(reference, nothing)[1]) if is_closed else None
    at_reference = reference_rank is not None and reference_rank.value == generic.value
    values = reference if at_reference else values
    closed = is_closed or bool((misfits <= CLOSED_CONFIGURATION * size).any())
    digits = _to_digits(system, ends, misfits, generic.value if closed else None)
    if not closed and digits is not None:
        values = ends[int(np.argmin(misfits))]
    jacobian = system.linearise_one(values, nothing)[1]
    unknown = [k for k, c in enumerate(per_freedom(closure.coordinates)) if c.role != "actuated"]
    twists = platform_twists(closure, system, values) if mechanism.platform_link is not None else np.zeros((0, 6))
    wrenches = reciprocal_system(twists, size) if len(twists) else np.eye(6)
    return Mobility(
        closure=closure,
        values=values,
        at_reference=at_reference,
        closed=closed,
        freedoms=system.freedom,
        rows=int(closure.rows.shape[0]) + closure.vanishing,
        rank=generic,
        direct_rank=Rank.of(jacobian[:, unknown]),
        limbs=(),
        platform_constraints=row_space(wrenches, size) if mechanism.platform_link is not None else np.zeros((0, 6)),
        platform_twists=twists,
        gruebler=gruebler_kutzbach(mechanism),
        reference_rank=reference_rank,
        loops=loops_at(closure, values, RANK_TOLERANCE if digits is None else _DIGITS),
        digits=digits,
        misfit=None if closed or digits is not None else _misfit(closure, system, ends, misfits),
    )


def _to_digits(system: System, ends: np.ndarray, misfits: np.ndarray, rank: int | None) -> ToDigits | None:
    """What holds at ends that close the loops only to the digits of a file, where more moves there than exactly (`rank`), or where
    nothing closes exactly."""
    size = system.characteristic_length
    near = np.flatnonzero((misfits > CLOSED_CONFIGURATION * size) & (misfits <= _DIGITS * size))
    if not near.size:
        return None
    _, jacobians = system.linearise(ends[near], np.zeros(0))
    values = np.linalg.svd(jacobians, compute_uv=False)
    zero = np.maximum(_DIGITS, _BLUR * misfits[near] / size)[:, None] * values[:, :1]
    found = int(np.median(np.sum(values > zero, axis=1)))
    return ToDigits(float(misfits[near].max()), found) if rank is None or found < rank else None


def _misfit(closure: Closure, system: System, ends: np.ndarray, misfits: np.ndarray) -> Misfit:
    """The least of the misfits, and the smallest loop through the joint or rod whose row has most of it."""
    points = np.vstack([closure.reference, ends])
    errors = np.concatenate([system.residuals(closure.reference[None], np.zeros(0)), misfits])
    best = int(np.argmin(errors))
    rows, _ = system.linearise_one(points[best], np.zeros(0))
    worst = closure.row_sources[int(np.argmax(np.abs(rows)))].limb
    loops = [loop for loop in loops_at(closure, points[best]) if worst in loop.joints]
    return Misfit(float(errors[best]), min(loops, key=lambda loop: len(loop.joints)).name if loops else worst)
