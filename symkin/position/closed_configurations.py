"""Closed configurations of a mechanism beside its reference."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from symkin.closure.closure import Closure
from symkin.computed_once import lru_cache
from symkin.numeric.nearest_root import NearestRoot
from symkin.numeric.system import System
from symkin.numeric.tolerances import CLOSED_CONFIGURATION, CLOSURE_TOLERANCE
from symkin.position.file_digits import LeastSquaresEnds, least_squares_from, rank_to_digits
from symkin.position.own_component import Component, component_at_singular, regular_component


@lru_cache(maxsize=128)
def whole_system(closure: Closure) -> System:
    """The closure with every coordinate unknown."""
    rows, errors = closure.bound(closure.rows), closure.bound(closure.errors)
    return System(
        closure.coordinates,
        closure.variables,
        ca.SX(0, 1),
        rows,
        errors,
        closure.characteristic_length,
    )


@dataclass(frozen=True, eq=False)
class Assembly:
    """A system of all coordinates as unknowns, and the configuration that a file describes."""

    system: System
    reference: np.ndarray


@lru_cache(maxsize=128)
def assembly_of(closure: Closure) -> Assembly:
    """That of a mechanism."""
    return Assembly(whole_system(closure), closure.reference)


@lru_cache(maxsize=128)
def begun_closed(assembly: Assembly) -> np.ndarray:
    """The reference, or the closed configuration nearest to it where that is open; what comes
    nearest to one where none is found.
    """
    system, start = assembly.system, assembly.reference
    if system.residual(start) <= CLOSURE_TOLERANCE * system.characteristic_length:
        return start
    return NearestRoot(system, start).found()


@lru_cache(maxsize=128)
def own_component(assembly: Assembly, seed: int) -> Component | None:
    """Configurations of the assembly that the reference belongs to, or the nearest that closes
    where the reference is open; None where no search from there closes.
    """
    system, start = assembly.system, begun_closed(assembly)
    if not system.residual(start) <= CLOSED_CONFIGURATION * system.characteristic_length:
        return None
    found = regular_component(system, start, seed)
    if found.infinitesimal:
        # a singular file of few digits: what closes exactly beside it is less than what its digits
        # mean
        digits = rank_to_digits(system, least_squares_ends(assembly, 0), found.rank.value)
        return found if digits is not None else component_at_singular(system, start, seed)
    return found


def closed_configurations(closure: Closure, seed: int) -> list[np.ndarray]:
    """Generic closed configurations of the reference's own assembly; of a reference that is open
    and near to none, those where least squares ends, or itself where none closes.
    """
    assembly = assembly_of(closure)
    own = own_component(assembly, seed)
    if own is not None:
        return list(own.points)
    ends = least_squares_ends(assembly, seed)
    return list(ends.points[ends.closed]) or [closure.reference]


@lru_cache(maxsize=128)
def least_squares_ends(assembly: Assembly, seed: int) -> LeastSquaresEnds:
    """Where least squares on all rows from random steps off the reference ends, in whatever
    assembly.
    """
    return least_squares_from(assembly.system, assembly.reference, seed)
