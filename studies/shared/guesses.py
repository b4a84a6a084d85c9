"""Enumeration of modes from varied initial guesses, by CasADi's own solvers on the closure as a
paper writes it.

A closure F(X, u) = 0 has unknowns X and given values u. From each guess of X run two searches:
Newton's method by CasADi's `rootfinder`, and least squares, min |F|^2 / 2, by IPOPT. An end counts
only if every row of F vanishes there; which mode it is, is read off the list that continuation
gives. `symkin.modes(..., method="multistart")` is the third search: Levenberg-Marquardt on all
rows, all guesses at once.

    table:  solver | guesses | modes met | hits per mode | failures | iterations | time

Everything is deterministic: guesses come from a seed, and times stand in rows of their own.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

CLOSED = 1e-8
"""Largest |F| / size at which an end closes the loops; a search that converges leaves 1e-12 or
less.
"""
SAME = 1e-5
"""Largest difference (angles in rad, lengths over the size) between an end and the mode that it
is.
"""
ROOTFINDER = {"abstol": 1e-11, "max_iter": 100, "error_on_fail": False, "show_eval_warnings": False}
IPOPT = {
    "print_time": False,
    "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-12, "max_iter": 200},
    "show_eval_warnings": False,
}


@dataclass(frozen=True, eq=False)
class Closure:
    """F(X, u) with rows in one unit of length; `angles` marks the unknowns that are angles (rad);
    `size` is the mechanism's characteristic length, in the unit of F and of the unknowns that are
    lengths.
    """

    X: ca.SX
    u: ca.SX
    F: ca.SX
    angles: Sequence[bool]
    size: float

    @cached_property
    def rows(self) -> ca.Function:
        return ca.Function("F", [self.X, self.u], [self.F])

    def residual(self, X: np.ndarray, u: np.ndarray) -> float:
        """Return the largest |F| over the size; infinite where F is not finite. Whole turns are
        left out: after 1e7 of them a sine has nine digits left.
        """
        X = np.asarray(X, dtype=float)
        X = np.where(self.angles, X - 2 * np.pi * np.round(X / (2 * np.pi)), X)
        value = float(np.abs(np.asarray(self.rows(X, u))).max()) / self.size
        return value if np.isfinite(value) else np.inf

    def nearest(self, X: np.ndarray, modes: Sequence[np.ndarray]) -> int | None:
        """Find the index of the mode that X is, modulo whole turns; None where it is none of
        them.
        """
        for index, mode in enumerate(modes):
            if self.distance(X, mode) < SAME:
                return index
        return None

    def distance(self, X: np.ndarray, mode: np.ndarray) -> float:
        gap, turns = np.asarray(X) - mode, np.asarray(self.angles)
        gap = np.where(turns, (gap + np.pi) % (2 * np.pi) - np.pi, gap / self.size)
        return float(np.abs(gap).max())


@dataclass(frozen=True)
class End:
    """Where one guess has led: the point, its residual over the size, the iterations, and the
    seconds taken.
    """

    X: np.ndarray
    residual: float
    iterations: int
    seconds: float

    @property
    def closed(self) -> bool:
        return self.residual <= CLOSED


@dataclass(frozen=True, eq=False)
class Search:
    """One solver on one closure: `solver(guess, u)` gives the end, `iterations` the count of its
    last call.
    """

    name: str
    closure: Closure
    solver: Callable[[np.ndarray, np.ndarray], np.ndarray]
    iterations: Callable[[], int]

    def end(self, guess: np.ndarray, u: np.ndarray) -> End:
        begin = time.perf_counter()
        X = np.asarray(self.solver(guess, u), dtype=float).ravel()
        seconds = time.perf_counter() - begin
        residual = self.closure.residual(X, u) if np.all(np.isfinite(X)) else np.inf
        return End(X, residual, self.iterations(), seconds)


def rootfinder(closure: Closure) -> Search:
    """Search by Newton's method with CasADi's line search: as many rows as unknowns."""
    find = ca.rootfinder(
        "newton", "newton", {"x": closure.X, "p": closure.u, "g": closure.F}, ROOTFINDER
    )
    return Search(
        "rootfinder",
        closure,
        lambda X, u: find(x0=X, p=u)["x"],
        lambda: int(find.stats()["iter_count"]),
    )


def least_squares(closure: Closure) -> Search:
    """Search min |F|^2 / (2 size^2) by IPOPT: any number of rows."""
    cost = 0.5 * ca.sumsqr(closure.F / closure.size)
    find = ca.nlpsol("ipopt", "ipopt", {"x": closure.X, "p": closure.u, "f": cost}, IPOPT)
    return Search(
        "IPOPT", closure, lambda X, u: find(x0=X, p=u)["x"], lambda: int(find.stats()["iter_count"])
    )


@dataclass(frozen=True, eq=False)
class Trial:
    """The ends of one search from many guesses, and the mode of each (None: no mode)."""

    search: Search
    ends: list[End]
    modes: int
    found: list[int | None]

    def evidence(self) -> dict[str, object]:
        """Say what was run, for a row of a report."""
        name, count = self.search.name, len(self.ends)
        return {
            "by": f"casadi {name}",
            "method": name,
            "starts": count,
            "text": f"{name}, {count} guesses",
        }

    @property
    def hits(self) -> list[int]:
        """Count the guesses that led to each mode, in the order of the list of modes."""
        return [self.found.count(k) for k in range(self.modes)]

    @property
    def met(self) -> int:
        return sum(h > 0 for h in self.hits)

    @property
    def failures(self) -> int:
        """Count the guesses that led to no closed configuration."""
        return sum(not end.closed for end in self.ends)

    @property
    def unknown(self) -> int:
        """Count the guesses that closed the loops at a configuration that is not in the list of
        modes.
        """
        return sum(end.closed and k is None for end, k in zip(self.ends, self.found, strict=True))

    @property
    def needed(self) -> int | None:
        """Count the guesses until the last mode was met; None where a mode was missed."""
        if self.met < self.modes:
            return None
        return 1 + max(self.found.index(k) for k in range(self.modes))

    @property
    def iterations(self) -> list[int]:
        """Return median and largest number of iterations of the guesses that led to a mode."""
        counts = [
            end.iterations for end, k in zip(self.ends, self.found, strict=True) if k is not None
        ]
        return [int(np.median(counts)), max(counts)] if counts else []

    @property
    def milliseconds(self) -> float:
        return 1e3 * float(np.median([end.seconds for end in self.ends]))


def attempt(
    search: Search, guesses: np.ndarray, u: np.ndarray, modes: Sequence[np.ndarray]
) -> Trial:
    """Run a search from each guess (rows) and tell which mode it found."""
    ends = [search.end(guess, u) for guess in guesses]
    found = [search.closure.nearest(end.X, modes) if end.closed else None for end in ends]
    return Trial(search, ends, len(modes), found)


def report_trials(report, what: str, place: str, trials: Sequence[Trial]) -> None:
    """Report the rows of the table: for each search modes met, hits, guesses needed, failures,
    iterations, and the time apart.
    """
    for trial in trials:
        name = f"{what}, {trial.search.name}"
        missed = trial.modes - trial.met
        report.row(
            f"{name}: modes met, of {trial.modes}; missed",
            None,
            [trial.met, missed],
            place=place,
            run=trial,
        )
        report.row(f"{name}: hits per mode", None, trial.hits, place=place, run=trial)
        needed = "not all met" if trial.needed is None else trial.needed
        report.row(
            f"{name}: guesses needed until every mode was met", None, needed, place=place, run=trial
        )
        report.row(
            f"{name}: guesses that led to no solution", None, trial.failures, place=place, run=trial
        )
        report.row(
            f"{name}: iterations, median and most", None, trial.iterations, place=place, run=trial
        )
        report.row(
            f"{name}: time a guess, median",
            None,
            trial.milliseconds,
            "ms",
            place=place,
            run=trial,
            volatile=True,
        )
        if trial.unknown:
            raise SystemExit(
                f"{report.name}: {name} closed the loops {trial.unknown} times outside the list of "
                f"modes"
            )


def draw_basins(
    axes,
    search: Search,
    u: np.ndarray,
    modes: Sequence[np.ndarray],
    plane: tuple[int, int],
    at: np.ndarray,
    ranges: Sequence[tuple[float, float]],
    colours: Sequence[str],
    *,
    points: int = 61,
    scales: tuple[float, float] = (1.0, 1.0),
) -> np.ndarray:
    """Colour each guess of a plane of two unknowns (the others at `at`) by the mode that it leads
    to, white where it leads to none. `scales` turn unknowns into the units drawn. Returns the index
    of each guess's mode, -1 for none.
    """
    i, j = plane
    first, second = (np.linspace(*r, points) for r in ranges)
    image = np.full((points, points), -1)
    for row, b in enumerate(second):
        for column, a in enumerate(first):
            guess = np.array(at, dtype=float)
            guess[[i, j]] = a, b
            end = search.end(guess, u)
            found = search.closure.nearest(end.X, modes) if end.closed else None
            image[row, column] = -1 if found is None else found
    from matplotlib.colors import ListedColormap

    extent = [*(scales[0] * v for v in ranges[0]), *(scales[1] * v for v in ranges[1])]
    shown = ListedColormap(["white", *colours[: len(modes)]])
    axes.imshow(
        image,
        origin="lower",
        extent=extent,
        aspect="auto",
        cmap=shown,
        vmin=-1.5,
        vmax=len(modes) - 0.5,
        interpolation="nearest",
    )
    _mark_modes(axes, modes, plane, scales, extent, colours)
    return image


def _mark_modes(
    axes, modes, plane: tuple[int, int], scales: tuple[float, float], extent: list[float], colours
) -> None:
    """Draw a circle where modes lie in the plane, with their numbers; modes that lie at one place
    share it.
    """
    places: dict[tuple[float, float], list[int]] = {}
    for index, mode in enumerate(modes):
        x, y = (round(scale * mode[k], 3) for scale, k in zip(scales, plane, strict=True))
        if extent[0] <= x <= extent[1] and extent[2] <= y <= extent[3]:
            places.setdefault((x, y), []).append(index)
    for (x, y), indices in places.items():
        low = y > extent[2] + 0.9 * (extent[3] - extent[2])
        axes.plot(x, y, "o", mfc=colours[indices[0]], mec="black", ms=9, mew=1.4)
        axes.annotate(
            ", ".join(str(k + 1) for k in indices),
            (x, y),
            xytext=(8, -14 if low else 5),
            textcoords="offset points",
            fontsize=11,
            fontweight="bold",
        )
