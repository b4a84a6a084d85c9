"""What is proved of a block's modes: each one by a certificate, and their number where a theorem bounds it."""

from __future__ import annotations

import numpy as np

from symkin.enumeration.algebraic import AlgebraicSystem
from symkin.enumeration.roots import Proofs
from symkin.enumeration.systems import whole_system
from symkin.enumeration.values import algebraic_point
from symkin.position.given import Given
from symkin.position.problem import Problem
from symkin.position.system import System


def prove(problem: Problem, system: AlgebraicSystem, block: System, ends: np.ndarray, points: np.ndarray, given: Given) -> Proofs:
    """Certificates of the complex roots `ends` (width, n) of a block and of its real ones, `points` (m, width)."""
    from symkin.enumeration.bounds import bound_of, proves
    from symkin.enumeration.certificate import certify
    from symkin.enumeration.exact import exact_known

    size = problem.closure.size
    whole = whole_system(problem, block)
    places = [{c.name: z[place] for c, place in zip(block.unknowns, block.slices, strict=True)} for z in points]
    real = [algebraic_point(problem, whole, values) for values in places]
    bound = bound_of(problem, system)
    if whole is not system or system.limbs:
        ends = np.array(real).T.reshape(whole.width, len(real))
    if bound is not None:
        found = certify(bound.system, ends, bound.known(given.values), size)
    else:
        found = certify(whole, ends, exact_known(problem, given.values), size)
    pairs = [found.find(z) for z in real]
    complete = bound is not None and proves(found, bound) and len(points) == int(np.sum(found.real == "real"))
    return Proofs(
        np.array([pair is not None for pair in pairs], dtype=bool),
        np.array([np.nan if pair is None else pair[1] for pair in pairs]),
        f"{bound.theorem.count}: {bound.theorem.about} ({bound.theorem.reference})" if bound is not None and complete else None,
        found.distinct,
        next((reason for reason in found.reasons if reason), None) if None in pairs else None,
    )
