"""The compiled engine: path tracking in C with a path in each vector lane, where a C compiler is
found.

The closure's rows and derivatives are written as C (see `lane_code`), compiled once with the
tracker of `data/tracker.c` into the user's cache folder, and give what `tracker.track` and
`tracker.newton` give. SYMKIN_ENGINE = numpy turns it off.
"""

from __future__ import annotations

import ctypes
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symkin.computed_once import lru_cache
from symkin.errors import InputError
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.lane_code import closure_source
from symkin.homotopy.tracker import Tracked, TrackSettings
from symkin.numeric.c_library import (
    LANES,
    OFF,
    CompilerError,
    NotBuiltError,
    find_compilers,
    load_library,
)
from symkin.numeric.cache_folder import cache_folder
from symkin.numeric.shared_library import begin_of
from symkin.numeric.tolerances import ROOT_POLISHED, ROWS_CONTRADICT

DATA = Path(__file__).resolve().parent / "data"
SOURCES = (DATA / "tracker.c", DATA / "elimination.h", LANES)
"""Files of the engine that are the same for every closure."""
SYMBOLS = ("symkin_track", "symkin_newton")


class _Settings(ctypes.Structure):
    """`settings` of tracker.c: largest first correction of a step; sizes of a last correction on
    the way and at the end; largest further row at the end; steps; the first correction that steps
    aim at; bounds on counts.
    """

    _fields_ = [
        *((name, ctypes.c_double) for name in ("tolerance", "accepted", "polished", "left")),
        *((name, ctypes.c_double) for name in ("first_step", "smallest_step", "longest", "aim")),
        *((name, ctypes.c_int) for name in ("most_steps", "corrections", "polishing")),
    ]


@dataclass(frozen=True, eq=False)
class CompiledTracker:
    """`track` and `newton` of one system."""

    system: AlgebraicSystem
    library: ctypes.CDLL

    def track(
        self,
        z: np.ndarray,
        begin: np.ndarray,
        end: np.ndarray,
        settings: TrackSettings | None = None,
    ) -> Tracked:
        """Track roots z (width, n) of F(., begin) to roots of F(., end), known values (known,) or
        (known, n), as `tracker.track` does.
        """
        points, n = self._points(z)
        first, along = self._line(begin, end, n)
        s, tries = np.zeros(n), np.zeros(n, dtype=np.intc)
        ends, chosen = np.empty_like(points), _c_settings(settings or TrackSettings())
        self.library.symkin_track(
            n,
            begin_of(points),
            begin_of(first),
            begin_of(along),
            int(first.ndim > 1),
            ctypes.byref(chosen),
            begin_of(ends),
            begin_of(s),
            begin_of(tries),
        )
        return Tracked(ends.T, s >= 1.0, s, tries)

    def newton(
        self, z: np.ndarray, k: np.ndarray, iterations: int = 5
    ) -> tuple[np.ndarray, np.ndarray]:
        """Newton at fixed k, as `tracker.newton` does; a point that has no finite step stays where
        it is.
        """
        points, n = self._points(z)
        ends, last, known = np.empty_like(points), np.zeros(n), self._line(k, k, n)[0]
        self.library.symkin_newton(
            n,
            begin_of(points),
            begin_of(known),
            int(known.ndim > 1),
            iterations,
            ROWS_CONTRADICT,
            begin_of(ends),
            begin_of(last),
        )
        return ends.T, last

    def _points(self, z: np.ndarray) -> tuple[np.ndarray, int]:
        """Points (width, n) as (n, width) in one piece; and n."""
        if z.ndim != 2 or z.shape[0] != self.system.width:
            raise ValueError(
                f"points of shape {z.shape}; the system has {self.system.width} unknowns"
            )
        return np.ascontiguousarray(z.T, dtype=complex), z.shape[1]

    def _line(self, begin: np.ndarray, end: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
        """begin and end - begin, both (known,) or both (n, known), in one piece."""
        known = self.system.k.shape[0]
        first, last = (np.ascontiguousarray(np.asarray(k).T, dtype=complex) for k in (begin, end))
        if first.ndim + last.ndim > 2:
            first, last = (
                np.ascontiguousarray(np.broadcast_to(k, (n, k.shape[-1]))) for k in (first, last)
            )
        if first.shape[-1] != known or last.shape[-1] != known:
            raise ValueError(
                f"{first.shape[-1]} and {last.shape[-1]} known values; the system has {known}"
            )
        return first, last - first


def load(system: AlgebraicSystem, *, build: bool = True) -> tuple[CompiledTracker | None, str]:
    """The compiled tracker of a system, from the cache or, if `build`, compiled now; None where
    there is none. And what was chosen or why not, in a few words.
    """
    engine = os.environ.get("SYMKIN_ENGINE", "")
    if engine == OFF:
        return None, f"SYMKIN_ENGINE = {OFF}"
    if engine not in ("", "compiled"):
        raise InputError(
            f"SYMKIN_ENGINE = {engine!r} is unknown; allowed: {OFF}, compiled, or nothing"
        )
    try:
        return _load(
            system, os.environ.get("CC", ""), os.environ.get("PATH", ""), cache_folder(), build
        )
    except NotBuiltError as error:
        return None, str(error)


@lru_cache(maxsize=128)
def _load(
    system: AlgebraicSystem, named: str, path: str, folder: Path, build: bool
) -> tuple[CompiledTracker | None, str]:
    """What was found for good. Raises NotBuiltError where it may be found later."""
    try:
        library = load_library(
            find_compilers(named, path),
            dict(_sources(system)),
            SYMBOLS,
            folder,
            build=build,
        )
    except NotBuiltError:
        raise
    except (CompilerError, NotImplementedError, OSError) as error:
        return None, str(error)
    return CompiledTracker(system, _declare(library)), "compiled C"


@lru_cache(maxsize=128)
def _sources(system: AlgebraicSystem) -> tuple[tuple[str, str], ...]:
    return (
        *((path.name, path.read_text()) for path in SOURCES),
        ("closure.h", closure_source(system)),
    )


def _declare(library: ctypes.CDLL) -> ctypes.CDLL:
    pointer, number = ctypes.c_void_p, ctypes.c_int
    library.symkin_track.argtypes = [number, pointer, pointer, pointer, number, *[pointer] * 4]
    library.symkin_newton.argtypes = [
        number,
        pointer,
        pointer,
        number,
        number,
        ctypes.c_double,
        pointer,
        pointer,
    ]
    library.symkin_track.restype = library.symkin_newton.restype = None
    return library


def _c_settings(settings: TrackSettings) -> _Settings:
    """A prediction is aimed at 0.3 of the largest first correction; a tenth of that is settled, as
    in `tracker`. The first step has a predictor of second order only, and is shorter for that.
    """
    tolerance = settings.tolerance
    return _Settings(
        tolerance=tolerance,
        accepted=0.1 * tolerance,
        polished=ROOT_POLISHED,
        left=ROWS_CONTRADICT,
        first_step=0.2 * settings.first_step,
        smallest_step=settings.smallest_step,
        longest=2.0,
        aim=0.3 * tolerance,
        most_steps=settings.most_steps,
        corrections=3,
        polishing=6,
    )
