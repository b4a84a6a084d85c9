"""Choose configurations by exchange: N of many candidates so that a criterion of the covariance is
least.

Each candidate adds K whitened rows a = (A_i, -B_i at its wedge's columns) in the unknowns
(parameters, two inclinations for each wedge): M = M_0 + sum a^T a, C = M^-1, M_0 a weak prior.
Adding or removing one candidate changes C by a matrix of rank K (Woodbury), so that a criterion for
all candidates is a few small products. (Where one is removed that almost alone tells something C is
made anew: a difference would be rounding.) What is made least:

  I, A    trace(Q C)        Q the mean of squared pose slopes, or 1 for the parameters
  D       log det of C's part for the parameters

Source: Fedorov, Theory of optimal experiments, 1972; Atkinson, Donev, Optimum experimental designs,
1992.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

Criterion = Literal["D", "A", "I"]
_MAX_WEDGE_EXCHANGES = 5
"""Wedges that are exchanged for others, one after the other, at most."""
_LEAST_LEFT = 0.05
"""Share of the information along a candidate's rows that the others must hold for C without it to
be a difference.
"""


class Candidates(NamedTuple):
    """Rows (n, K, P) of parameters, (n, K, 2) of the group's inclination, and the wedge (n,) of
    each configuration, -1: none.
    """

    rows: np.ndarray
    group: np.ndarray
    wedge: np.ndarray

    def thinned(self, each: int) -> Candidates:
        """Keep the first `each` candidates of every wedge."""
        kept = np.concatenate(
            [np.flatnonzero(self.wedge == w)[:each] for w in np.unique(self.wedge)]
        )
        return Candidates(self.rows[kept], self.group[kept], self.wedge[kept])


class ExchangeSearch:
    """The search among candidates: greedy construction, then exchange of single configurations
    until none helps.
    """

    def __init__(
        self, candidates: Candidates, wedges: int, criterion: Criterion, q: np.ndarray, prior: float
    ) -> None:
        self.candidates, self.wedges = candidates, wedges
        self.criterion, self.prior = criterion, prior
        count, k, self.width = candidates.rows.shape
        # in all unknowns, (n, K, P + 2 W)
        self.rows = np.zeros((count, k, self.width + 2 * wedges))
        self.rows[:, :, : self.width] = candidates.rows
        for place in range(wedges):
            inside, begin = candidates.wedge == place, self.width + 2 * place
            self.rows[inside, :, begin : begin + 2] = -candidates.group[inside]
        self.q = np.zeros((self.rows.shape[2],) * 2)
        self.q[: self.width, : self.width] = np.eye(self.width) if criterion == "A" else q
        values, vectors = np.linalg.eigh(self.q)
        told = values > 1e-15 * values[-1]
        self._root = vectors[:, told] * np.sqrt(values[told])

    def covariance(self, chosen: list[int]) -> np.ndarray:
        """Return C (P + 2 W) of chosen candidates, by a QR decomposition of their rows: squares of
        precise rows would drown the prior.
        """
        flat = self.rows[chosen].reshape(-1, self.rows.shape[2])
        weak = np.concatenate([np.full(self.width, self.prior), np.full(2 * self.wedges, 1.0)])
        factor = np.linalg.qr(np.vstack([flat, np.diag(np.sqrt(weak))]), mode="r")
        root = np.linalg.solve(factor, np.eye(len(weak)))
        return root @ root.T

    def value(self, c: np.ndarray) -> float:
        """Return the criterion, less is better."""
        if self.criterion == "D":
            return float(np.linalg.slogdet(c[: self.width, : self.width])[1])
        return float(np.sum(self.q * c))

    def gains(self, c: np.ndarray, index: np.ndarray) -> np.ndarray:
        """Return by how much the criterion falls when one of the candidates of `index` is added."""
        rows = self.rows[index]
        spread = (rows.reshape(-1, len(c)) @ c).reshape(rows.shape)
        inner = spread @ rows.transpose(0, 2, 1) + np.eye(rows.shape[1])
        if self.criterion == "D":
            part, own = spread[:, :, : self.width], c[: self.width, : self.width]
            share = part @ np.linalg.pinv(own, hermitian=True) @ part.transpose(0, 2, 1)
            return np.linalg.slogdet(inner)[1] - np.linalg.slogdet(inner - share)[1]
        moved = (spread.reshape(-1, len(c)) @ self._root).reshape(*rows.shape[:2], -1)
        weight = moved @ moved.transpose(0, 2, 1)
        return np.sum(np.linalg.inv(inner) * weight, axis=(1, 2))

    def without(self, c: np.ndarray, chosen: list[int], place: int) -> np.ndarray:
        """Return C after one of the chosen candidates is removed."""
        rows = self.rows[chosen[place]]
        spread = rows @ c
        inner = np.eye(len(rows)) - spread @ rows.T
        if not np.linalg.eigvalsh(inner)[0] > _LEAST_LEFT:
            return self.covariance(chosen[:place] + chosen[place + 1 :])
        return c + spread.T @ np.linalg.solve(inner, spread)

    def updated(self, c: np.ndarray, k: int) -> np.ndarray:
        """Return C after one candidate is added."""
        rows = self.rows[k]
        spread = rows @ c
        inner = np.eye(len(rows)) + spread @ rows.T  # Woodbury: (M + a^T a)^-1
        return c - spread.T @ np.linalg.solve(inner, spread)

    def greedy(self, count: int, allowed: set[int], kept: Sequence[int] = ()) -> list[int]:
        """Choose candidates beside those that are kept one by one, each the best to add; none
        twice. A wedge's first configuration says nothing yet, so that each wedge is given one to
        begin with, as far as two of each can be had.
        """
        wedge = self.candidates.wedge
        index = np.flatnonzero(np.isin(wedge, list(allowed)))
        begun = sorted(allowed)[: count // 2] if self.wedges else []
        new = [int(np.argmax(wedge == w)) for w in begun if w not in wedge[list(kept)]]
        chosen = [*kept, *new][:count]
        c = self.covariance(chosen)
        for _ in range(count - len(chosen)):
            gains = self.gains(c, index)
            gains[np.isin(index, chosen)] = -np.inf
            chosen.append(int(index[gains.argmax()]))
            c = self.updated(c, chosen[-1])
        return chosen

    def improve(self, chosen: list[int], allowed: set[int], passes: int = 6) -> list[int]:
        """Take each configuration out in turn and put the best candidate in its place, until a
        whole pass changes nothing.
        """
        chosen = list(chosen)
        index = np.flatnonzero(np.isin(self.candidates.wedge, list(allowed)))
        for _ in range(passes):
            changed, c = False, self.covariance(chosen)
            for place, old in enumerate(chosen):
                without = self.without(c, chosen, place)
                gains = self.gains(without, index)
                gains[np.isin(index, chosen[:place] + chosen[place + 1 :])] = -np.inf
                best = int(index[gains.argmax()])
                if best != old and gains.max() > (1 + 1e-6) * self.gains(without, np.array([old])):
                    chosen[place], changed = best, True
                    c = self.updated(without, best)
            if not changed:
                break
        return chosen

    def best_wedges(self, count: int, groups: int) -> set[int]:
        """Choose the wedges when only `groups` of them may be used: the best of three
        beginnings (those that a choice among all uses most, least, the first), then one exchanged
        for another while that helps. A set is worth what a greedy choice with one pass of exchanges
        makes of it; a set with one wedge exchanged keeps the configurations on the others.
        """
        if not self.wedges:
            return {-1}
        everything, groups = set(range(self.wedges)), max(groups, 1)
        if len(everything) <= groups:
            return everything

        def choice(wedges: set[int], kept: Sequence[int] = ()) -> tuple[float, list[int]]:
            chosen = self.greedy(count, wedges, kept)
            if not kept:
                chosen = self.improve(chosen, wedges, passes=1)
            return self.value(self.covariance(chosen)), chosen

        used = self.candidates.wedge[self.greedy(count, everything)]
        most = np.argsort(-np.bincount(used, minlength=self.wedges), kind="stable")
        ends = (most, most[::-1], range(self.wedges))
        sets = [set(list(map(int, end))[:groups]) for end in ends]
        (worth, chosen), best = min(((choice(s), s) for s in sets), key=lambda t: t[0][0])
        for _ in range(_MAX_WEDGE_EXCHANGES):
            trials = [
                (choice(now, [k for k in chosen if self.candidates.wedge[k] != out])[0], now)
                for out in sorted(best)
                for now in (best - {out} | {new} for new in sorted(everything - best))
            ]
            trial = min(trials, key=lambda t: t[0])[1]
            found = choice(trial)
            if not found[0] < worth:
                break
            (worth, chosen), best = found, trial
        return best
