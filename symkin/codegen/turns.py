"""Write the C of an angle's cosine and sine together, for types in which a short polynomial is exact to rounding."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symkin.codegen.c_emitter import Real
from symkin.codegen.c_templates import fill
from symkin.codegen.closed_source import horner

_SINE = (-0.16666650571233543, 0.008331973139100734, -0.00019494934002867504)
"""(sin(x) / x - 1) / x^2 in x^2 up to an eighth of a turn, error of the sine 2e-9: least squares reweighted to the least largest error."""
_COSINE = (0.041666646745247254, -0.0013887361320206655, 2.4437714559667177e-05)
"""(cos(x) - 1 + x^2 / 2) / x^4 in the same way, error of the cosine 1e-10."""


def cosine_and_sine(real: Real, values: Mapping[str, object]) -> str:
    """NAME_cosine_and_sine of float code."""
    literal, quarter = real.literal, 0.5 * np.pi
    # parts of few digits, whose products with a count of quarters are exact
    first = float(np.float32(round(quarter * 2**8) / 2**8))
    second = float(np.float32(round((quarter - first) * 2**18) / 2**18))
    return fill("closed_turn.c", {
        **values, "per_quarter": literal(2.0 / np.pi), "quarter1": literal(first), "quarter2": literal(second),
        "quarter3": literal(quarter - first - second), "sine": horner(_SINE, real), "cosine": horner(_COSINE, real),
        "minus_half": literal(-0.5),
    })  # fmt: skip
