"""Real roots of one group at many instances, by paths, with what is in doubt left to others.

All steps take all instances together: paths, certificates of the complex roots, real candidates,
Newton's method on the group's own rows, the check on all rows. An instance is plain where none of
them leaves a doubt: every path arrived at a regular root of its own, every root is real or not
beyond doubt, and every real one is well conditioned and differs from the others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from symkin.assembly.group_roots import GroupRoots, checked_roots
from symkin.assembly.prover import Prover, prover_of
from symkin.computed_once import cached_property, lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem, imaginary_part
from symkin.homotopy.engine import engine_of
from symkin.homotopy.many_instances import instances_at_once, plain_instances
from symkin.homotopy.monodromy import Fibre
from symkin.homotopy.start_store import TIED, start_of
from symkin.homotopy.structure import Structure
from symkin.homotopy.systems import meets_all_rows, squared, system_of, unsuitable
from symkin.homotopy.values import known_values, real_values
from symkin.numeric.cache_folder import cache_folder
from symkin.position.groups import is_tied
from symkin.position.problem import Problem

if TYPE_CHECKING:
    from symkin.certificate.certificate import CertificateBatch

_REAL, _NOT_REAL = 1e-10, 1e-4
"""Imaginary parts of roots below the first and above the second leave no doubt."""


@dataclass(frozen=True, eq=False)
class BlockPaths:
    """A group with its algebraic system and the start of its paths: its own, or those of its
    structure (`shared`), or those of combinations of its rows (`combined`).
    """

    problem: Problem
    algebraic: AlgebraicSystem
    start: Fibre
    shared: Structure | None = None
    combined: bool = False

    @property
    def engine(self) -> str:
        """What tracks the paths."""
        return engine_of(self.algebraic)[1]

    @property
    def most_roots(self) -> int:
        """Complex roots of a generic instance."""
        return self.start.z.shape[1]

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Poses that no motion connects, over the complex numbers: operation modes. Roots of
        combinations of rows are none.
        """
        return () if self.combined else orbit_notes(self.start)

    @cached_property
    def prover(self) -> Prover:
        return prover_of(self.problem, self.algebraic, self.shared)

    @property
    def digest(self) -> bytes:
        """What the roots begin from."""
        return self.start.z.tobytes() + self.start.k.tobytes()

    def roots(
        self, known: np.ndarray, *, judges: bool = False, certifies: bool = False
    ) -> tuple[GroupRoots, np.ndarray]:
        """Roots at instances known (n, values), with what is `judged` of them if it `judges`, and
        those that are left in doubt. It `certifies` all of them where a theorem may tell then that
        none is.
        """
        k = known_values(self.problem, known.T)
        k = k if self.shared is None else self.shared.known(k)
        n, roots = len(known), self.most_roots
        certificates: list[CertificateBatch] = []

        def proves(ends: np.ndarray) -> np.ndarray:
            z, knowns = _side_by_side(ends), self.prover.knowns(known)
            certificates.append(self.prover.ends(z, knowns, np.arange(n).repeat(roots)))
            return self.prover.tells_all(certificates[0])

        together = n <= instances_at_once(self.start) and self.prover.may_complete(roots)
        ends, plain = plain_instances(
            self.algebraic, self.start, k, proves if certifies and together else None
        )
        z = _side_by_side(ends)
        part = imaginary_part(self.algebraic, z)
        # every root is real or not, beyond doubt
        plain &= ((part < _REAL) | (part > _NOT_REAL)).reshape(n, roots).all(axis=1)
        instance = np.arange(n).repeat(roots)
        if not plain.all():
            kept = plain[instance]
            certificates.clear()
            z, part, instance = z[:, kept], part[kept], instance[kept]
        whole = np.ones(len(instance), dtype=bool)
        if self.combined:
            whole = meets_all_rows(self.problem, self.algebraic, z, k[:, instance])
        counts = np.bincount(instance[whole], minlength=n)
        origin = (whole & (part < _REAL)).nonzero()[0]
        owner = instance[origin]
        points = self.points(z[:, origin], owner, k)
        points, kept, judged = checked_roots(
            self.problem.system, points, owner, known, plain, judges=judges
        )
        return GroupRoots.of_all(
            points,
            owner[kept],
            counts,
            engine=self.engine,
            orbits=self.notes,
            ends=z,
            ends_of=instance,
            origin=origin[kept],
            judged=judged,
            certificates=next(iter(certificates), None),
        ), (~plain).nonzero()[0]

    def points(self, z: np.ndarray, owner: np.ndarray, k: np.ndarray) -> np.ndarray:
        """Points of the group for real roots z (width, any) at the instances `owner`."""
        values = real_values(self.problem, self.algebraic, z, k[:, owner])
        names = [c.name for c in self.problem.system.unknowns]
        if self.shared is not None and not self.algebraic.projective:
            values = dict(zip(names, values.values(), strict=True))
        return np.concatenate([values[name] for name in names], axis=1)


def _side_by_side(ends: np.ndarray) -> np.ndarray:
    """Roots (width, n roots) of instances (n, width, roots), one after another."""
    return ends.transpose(1, 0, 2).reshape(ends.shape[1], -1)


def orbit_notes(start: Fibre) -> tuple[str, ...]:
    """What is said of generic roots that no loop of the known values connects."""
    sizes = np.bincount(start.orbits)
    sizes = sizes[sizes > 0]
    if len(sizes) < 2:
        return ()
    return (
        f"the generic modes fall into {len(sizes)} operation modes of "
        f"{', '.join(str(s) for s in sizes)} complex solutions",
    )


def own_paths(group: Problem) -> tuple[BlockPaths | None, str]:
    """What tracks the paths of a group's own rows, or of combinations of them where these are more
    than its unknowns and known values must satisfy conditions; None and why it has no start.
    """
    found, why = paths_of_rows(group)
    return _paths(group, True, str(cache_folder())) if why == TIED else (found, why)


def paths_of_rows(group: Problem) -> tuple[BlockPaths | None, str]:
    """What tracks the paths of a group's own rows as they are; None and why it has no start."""
    return _paths(group, False, str(cache_folder()))


@lru_cache(maxsize=256)
def _paths(group: Problem, combined: bool, _folder: str) -> tuple[BlockPaths | None, str]:
    """Paths whose start is read from the cache folder once in a process."""
    why = unsuitable(group)
    if why is not None:
        return None, why
    system = system_of(group)
    if combined:
        system = squared(system)
    elif is_tied(group) and not system.projective:
        return None, TIED
    start, why = start_of(group, system)
    return (
        (None, why) if start is None else (BlockPaths(group, system, start, combined=combined), "")
    )
