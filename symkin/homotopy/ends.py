"""What the paths of one instance came to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class SingularRoots:
    """Finite singular roots z (width, n), each once.

    `multiplicity` paths end there, in cycles of at most `turns` turns; the roots that they stand
    for lie within about `accuracy` (the distance of the ends that two circles gave, and the
    turns'th root of the rows that are left); `isolated` is false where complex roots of a continuum
    surround it.
    """

    z: np.ndarray
    multiplicity: np.ndarray
    turns: np.ndarray
    accuracy: np.ndarray
    isolated: np.ndarray

    @staticmethod
    def none(width: int) -> SingularRoots:
        empty = np.zeros(0, dtype=int)
        return SingularRoots(
            np.zeros((width, 0), dtype=complex), empty, empty, np.zeros(0), np.zeros(0, dtype=bool)
        )

    def __len__(self) -> int:
        return self.z.shape[1]


@dataclass(frozen=True, eq=False)
class Ends:
    """Regular roots z (width, n), singular ones, how many paths ended at infinity, and for each
    unresolved path the reason. Every path is counted once.
    """

    z: np.ndarray
    singular: SingularRoots
    at_infinity: int
    unresolved: tuple[str, ...]

    @property
    def points(self) -> np.ndarray:
        """All distinct finite roots, regular ones first."""
        return np.concatenate([self.z, self.singular.z], axis=1)

    @property
    def isolated(self) -> np.ndarray:
        """Distinct finite roots without those that a continuum surrounds."""
        return np.concatenate([self.z, self.singular.z[:, self.singular.isolated]], axis=1)

    @property
    def paths(self) -> int:
        """All paths: distinct regular roots, multiplicities, those at infinity, unresolved ones."""
        return (
            int(self.z.shape[1] + self.singular.multiplicity.sum())
            + self.at_infinity
            + len(self.unresolved)
        )
