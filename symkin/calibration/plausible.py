"""Is a converged fit a calibration at all, or a geometry bent until wrong readings fit as well as they can?

Noise that is stated too small or a model that lacks something leaves residuals some times as large as expected; such a fit is
not believable, and yet nearer to the truth than nominal. Readings that mean something else (columns exchanged, a sign, another
sequence) leave residuals far beyond any noise, and move the geometry by a large share of its size to reach even these.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from symkin.calibration.parameters import FRAMES
from symkin.calibration.residuals import ANGULAR

if TYPE_CHECKING:
    from symkin.calibration.departure import Departure
    from symkin.calibration.result import Calibration, Parameter, Residual

FAR = 0.2
"""A change of a parameter by more than this share of the size (angles: radians) is no correction of a nominal geometry."""
OTHER, NOTICED = 0.08, 0.02
"""A departure (see `departure`) by more than the first share is no correction of the machine that the file describes, but another
machine; one by more than the second is, where a slip of the columns would make it. Tolerances of some per mille of the size leave some
per mille, a nominal geometry measured with a ruler two or three per cent."""
_MOVED = 0.03
"""Changes of all parameters below this share of the size (angles: radians) are the same machine, however its poses differ: near
singularities they may by much."""
_TOLERANCES = 6.0
"""Changes within so many of the tolerances stated are what the user expects, however far they go."""
BEYOND = 30.0
"""Residuals so many times as large as the noise stated come from no noise: an instrument's is known better than to a decade."""
_COARSE = 1e-3
"""Where no noise is stated, residuals above this share of the size are coarser than any instrument that calibrates."""
_NO_BETTER = 0.5
"""Residuals above this share of the nominal geometry's say that the parameters do not explain the readings."""
_LARGEST = 3
"""Changes that are named."""
_BETTER_PART = 0.8
"""Share of the postures, those that fit better, by which fits are compared: single bad rows do not count."""


def refusal(
    fit: Calibration, at_nominal: float, suspicions: Sequence[str], gone: Departure, *, any_machine: bool = False
) -> str | None:
    """Why a converged fit is not to be used, None where nothing speaks against it; `at_nominal` is the misfit of the nominal
    geometry (see `residual_misfit`). With `any_machine` a geometry far from the file's is not refused for that."""
    beyond = _beyond(fit)
    misplaced = is_another(fit, gone) or (bool(suspicions) and is_noticed(fit, gone))
    if beyond is not None:
        why = _no_fit(fit, beyond, at_nominal, suspicions)
        if why is not None:
            return why
    return other_machine(fit, gone, suspicions) if misplaced and not any_machine else None


def _no_fit(fit: Calibration, beyond: str, at_nominal: float, suspicions: Sequence[str]) -> str | None:
    """Why residuals beyond any noise are those of no geometry, None where they may be of one that the model does not know."""
    moved = moved_far(fit)
    if moved:
        largest = max(moved, key=lambda p: _share(fit, p))
        how = "of the size" if largest.kind == "length" else "of a radian" if largest.kind == "angle" else "of one"
        return (
            f"{beyond}, although {largest.name} moved by {100 * _share(fit, largest):.0f} % {how}: no geometry near the nominal one fits "
            "these readings"
        )
    misfit = residual_misfit(fit.residuals, fit.mechanism.size)
    if misfit > _NO_BETTER * at_nominal:
        unit = fit.mechanism.length_unit
        return (
            f"{beyond}, hardly less than those of the nominal geometry ({misfit:.3g} {unit} after {at_nominal:.3g} {unit}, angles times "
            "the size): the parameters do not explain the readings"
        )
    return beyond if suspicions else None


def is_another(fit: Calibration, gone: Departure) -> bool:
    """Whether the fit is of another machine than the file describes, and further away than the tolerances stated expect."""
    within = fit.problem.prior is not None and max((abs(z) for _, z in tolerances_used(fit)), default=0.0) <= _TOLERANCES
    return gone.share > OTHER and not within and is_noticed(fit, gone)


def is_noticed(fit: Calibration, gone: Departure) -> bool:
    """Whether the geometry went so far that slips of the file are worth a search although it fits."""
    return gone.share > NOTICED and any(_share(fit, p) > _MOVED for p in fit.parameters if not p.held)


def beyond_tolerance(fit: Calibration) -> list[tuple[str, float]]:
    """Parameters that moved by more tolerances than expected, largest first, with how many."""
    found = [(name, abs(z)) for name, z in tolerances_used(fit) if abs(z) > _TOLERANCES]
    return sorted(found, key=lambda pair: -pair[1])


def tolerances_used(fit: Calibration) -> list[tuple[str, float]]:
    """Changes of free parameters over the tolerances stated."""
    prior, model = fit.problem.prior, fit.problem.model
    if prior is None:
        return []
    changes = (fit.state.p - model.nominal) / model.scales / prior
    return [(name, float(z)) for name, z, s in zip(model.names, changes, prior, strict=True) if np.isfinite(s)]


def other_machine(fit: Calibration, gone: Departure, suspicions: Sequence[str] = ()) -> str:
    """What is said of a geometry far from the file's, first what would explain it."""
    m = fit.mechanism
    size, free = m.size, [p for p in fit.parameters if not p.held]
    largest = sorted(free, key=lambda p: -abs(p.change) * (1.0 if p.kind == "length" else size))[:_LARGEST]
    changes = ", ".join(
        f"{p.name} {m.angle_out(p.change):+.3g} {m.angle_unit}" if p.kind == "angle"
        else f"{p.name} {p.change:+.3g}{f' {m.length_unit}' if p.kind == 'length' else ''}"
        for p in largest
    )  # fmt: skip
    unclosed = f"; {gone.open} of {gone.postures} postures the file's geometry cannot take there" if gone.open else ""
    cause = f"{suspicions[0]}; its" if suspicions else "its"
    return (
        f"another machine than {m.name} describes: {cause} poses are {100 * gone.share:.2g} % of their spread away from the file's at the same "
        f"joint readings ({gone.position:.3g} {m.length_unit} and {m.angle_out(gone.angle):.3g} {m.angle_unit} rms, frames aligned{unclosed}); "
        f"largest changes: {changes}; for a machine that is so, state --tolerance or --any-machine"
    )


def is_beyond(fit: Calibration) -> bool:
    """Whether residuals are larger than any noise would make them."""
    return _beyond(fit) is not None


def moved_far(fit: Calibration) -> list[Parameter]:
    """Free parameters that moved by more than `FAR`; measuring frames have no nominal place."""
    return [p for p in fit.parameters if not p.held and p.name not in FRAMES and _share(fit, p) > FAR]


def residual_misfit(residuals: Iterable[Residual], size: float) -> float:
    """Root mean square of a posture's residuals, angles times the size (length unit), over the better four fifths."""
    squares: dict[int, float] = {}
    for r in residuals:
        squares[r.posture] = squares.get(r.posture, 0.0) + (r.value * (size if r.kind in ANGULAR else 1.0)) ** 2
    return better_part(np.array(list(squares.values())))


def better_part(squares: np.ndarray) -> float:
    """Root of the mean of the smaller four fifths of some squares (n,)."""
    kept = np.sort(squares)[: max(1, math.ceil(_BETTER_PART * len(squares)))]
    return float(np.sqrt(np.mean(kept))) if len(kept) else 0.0


def _beyond(fit: Calibration) -> str | None:
    """The sentence that says how far residuals are beyond noise, None where they are not."""
    if fit.p_value is not None and fit.degrees > 0:
        times = math.sqrt(fit.chi_square / fit.degrees)
        return f"the residuals are {times:.3g} times as large as the noise stated" if times > BEYOND else None
    share = residual_misfit(fit.residuals, fit.mechanism.size) / fit.mechanism.size
    return f"the residuals are {100 * share:.2g} % of the size" if share > _COARSE else None


def _share(fit: Calibration, p: Parameter) -> float:
    """The change of a parameter over the size (lengths), in radians or plain."""
    return abs(p.change) / (fit.mechanism.size if p.kind == "length" else 1.0)
