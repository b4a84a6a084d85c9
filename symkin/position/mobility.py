"""Rank and mobility of a mechanism at closed configurations."""

from __future__ import annotations

import numpy as np

from symkin.closure.closure import Closure, build_closure
from symkin.computed_once import lru_cache
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.numeric.rank import Rank
from symkin.numeric.system import System
from symkin.numeric.tolerances import CLOSURE_TOLERANCE
from symkin.position.closed_configurations import (
    assembly_of,
    least_squares_ends,
    whole_system,
)
from symkin.position.file_digits import LeastSquaresEnds
from symkin.position.generic_rank import generic_rank
from symkin.position.gruebler import gruebler_kutzbach
from symkin.position.limb_screws import limb_screws, platform_screws
from symkin.position.loops import loops_at
from symkin.position.mobility_result import (
    Misfit,
    Mobility,
    count_rows,
    redundant_constraints,
)
from symkin.text import counted
from symkin.verb import verb
from symkin.verb_options import check_seed


def must_agree(mechanism: Mechanism) -> str | None:
    """What is said of actuated joints that do not move independently; None where they do."""
    found = mobility(mechanism)
    if not found.closed or found.direct_rank.value >= found.rank.value:
        return None
    if found.actuated <= found.mobility:
        return "about the reference the actuated joints cannot all move on their own"
    return (
        f"the values of the actuated joints must agree with each other: {found.actuated} of them "
        f"for {counted(found.mobility, 'freedom')}"
    )


@verb()
def mobility(mechanism: Mechanism, *, seed: int = 0) -> Mobility:
    """Count the freedoms of a mechanism: rank of the closure at generic configurations of the
    assembly that its file describes.

    mobility = freedoms of all coordinates - rank of dF / d(q, x, X) (the singular values below 1e-8
    of the largest count as zero), less freedoms of first order that no motion follows. Generic are
    configurations to which steps lead from the reference, along motions; other assemblies of the
    same links are told apart. Constraint wrenches of the limbs and the platform's twists,
    reciprocal to them, are those at the reference where its rank is the generic one, else at a
    configuration beside it. `seed` is that of the steps' directions. Raises InputError for what is
    no Mechanism, and for a negative seed. Screws: Hunt, Kinematic Geometry of Mechanisms, 1978.

    >>> import symkin
    >>> found = symkin.mobility(symkin.load("zhao2000"))
    >>> found.mobility, found.redundant, found.gruebler
    (4, 4, 1)
    """
    require_mechanism(mechanism)
    check_seed(seed)
    closure = build_closure(mechanism)
    system, size = whole_system(closure), closure.characteristic_length
    reference, reference_rank = closure.reference, None
    if system.residual(reference) <= CLOSURE_TOLERANCE * size:
        reference_rank = Rank.of(system.linearise_one(reference)[1])
    found = generic_rank(assembly_of(closure), seed)
    values, rank = found.values, found.rank
    generic = Rank(rank.value + found.above, float("inf")) if found.above else rank
    unknown = [c.role != "actuated" for c in closure.owners]
    direct = Rank.of(system.linearise_one(values)[1][:, unknown])
    limbs = limb_screws(closure, values)
    at_reference = reference_rank is not None and reference_rank.value == rank.value
    if at_reference:
        at_rest = limb_screws(closure, reference)
        at_reference = [s.counts for s in at_rest] == [s.counts for s in limbs]
        limbs, values = (at_rest, reference) if at_reference else (limbs, values)
    constraints, twists = platform_screws(closure, system, values, limbs)
    return Mobility(
        closure=closure,
        values=values,
        at_reference=at_reference,
        closed=found.closed,
        freedoms=system.freedom,
        rows=count_rows(closure),
        rank=generic,
        redundant=redundant_constraints(closure, found.values, rank.value) - found.above,
        direct_rank=direct,
        limbs=limbs,
        platform_constraints=constraints,
        platform_twists=twists,
        gruebler=gruebler_kutzbach(mechanism),
        reference_rank=reference_rank,
        digits=found.digits,
        other_ranks=found.other_ranks,
        misfit=_misfit(closure, system, least_squares_ends(assembly_of(closure), 0))
        if not found.closed and found.digits is None
        else None,
        infinitesimal=found.infinitesimal,
        ranks_apart=found.ranks_apart,
    )


@lru_cache(maxsize=64)
def open_loops_note(mechanism: Mechanism) -> str | None:
    """What is said of a mechanism that has no solution, whatever is given: how far its loops stay
    open, and which; else None.
    """
    closure = build_closure(mechanism)
    size = closure.characteristic_length
    if whole_system(closure).residual(closure.reference) <= CLOSURE_TOLERANCE * size:
        return None
    misfit = mobility(mechanism).misfit
    if misfit is None:
        return None
    return (
        f"no configuration closes the loops, whatever is given: the best one found leaves "
        f"{misfit.length:.3g} {mechanism.length_unit}, "
        f"most of it in the loop of {misfit.loop}; check its lengths and couplings"
    )


def _misfit(closure: Closure, system: System, ends: LeastSquaresEnds) -> Misfit:
    """The least of the misfits, and the smallest loop through the joint or rod whose row has most
    of it.
    """
    points = np.vstack([closure.reference, ends.points])
    errors = np.concatenate([system.residuals(closure.reference[None]), ends.misfits])
    best = int(np.argmin(errors))
    rows, _ = system.linearise_one(points[best])
    worst = closure.row_sources[int(np.argmax(np.abs(rows)))].limb
    loops = [loop for loop in loops_at(closure, points[best]) if worst in loop.joints]
    return Misfit(
        float(errors[best]), min(loops, key=lambda loop: len(loop.joints)).name if loops else worst
    )
