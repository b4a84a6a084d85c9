"""Write the C of angles in float code: cosine and sine, and the angle of a direction, by
polynomials that are exact to rounding or to what they are for; double code calls libm.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symkin.codegen.text.c import Real
from symkin.codegen.text.templates import fill

_SINE = (-0.16666650571233543, 0.008331973139100734, -0.00019494934002867504)
"""(sin(x) / x - 1) / x^2 in x^2 up to an eighth of a turn, error of the sine 2e-9: least squares
reweighted to the least largest error.
"""
_COSINE = (0.041666646745247254, -0.0013887361320206655, 2.4437714559667177e-05)
"""(cos(x) - 1 + x^2 / 2) / x^4 in the same way, error of the cosine 1e-10."""
_ROUGH_SINE = (
    0.9999966155528762,
    -0.16664828239792243,
    0.008306323850167805,
    -0.00018363616794956467,
)
"""sin(x) / x in x^2 up to a quarter turn, error of the sine 6e-7, made in the same way."""
_ARCTANGENT = (
    0.9999993443489075,
    -0.33329859375953674,
    0.19946563243865967,
    -0.13908618688583374,
    0.09642169624567032,
    -0.05591192841529846,
    0.02186267077922821,
    -0.004054484888911247,
)
"""atan(x) / x in x^2 up to x = 1, error of the angle 3.7e-8, made in the same way."""
_NEAR_ARCTANGENT = (
    1.0000016977664334,
    -0.33171134678251,
    0.18522155110672184,
    -0.09192949937020677,
    0.023864165672267342,
)
"""The same, never less and by at most 6.2e-5 of the angle more."""


def cosine_and_sine(real: Real, values: Mapping[str, object]) -> str:
    """NAME_cosine_and_sine, a function of an angle."""
    literal, quarter = real.literal, 0.5 * np.pi
    if real.name != "float":
        return fill("libm_turn.c", {**values, "cos": real.call("cos"), "sin": real.call("sin")})
    # parts of few digits, whose products with a count of quarters are exact
    first = float(np.float32(round(quarter * 2**8) / 2**8))
    second = float(np.float32(round((quarter - first) * 2**18) / 2**18))
    return fill(
        "closed_turn.c",
        {
            **values,
            "per_quarter": literal(2.0 / np.pi),
            "quarter1": literal(first),
            "quarter2": literal(second),
            "quarter3": literal(quarter - first - second),
            "sine": _horner(_SINE, real),
            "cosine": _horner(_COSINE, real),
            "eighth": literal(0.25 * np.pi),
        },
    )


def angle_of_direction(real: Real, values: Mapping[str, object], text: str = "atan2(") -> str:
    """NAME_angle of float code, in place of the atan2 that a text calls."""
    if real.name == "double" or "atan2(" not in text:
        return ""
    return fill("closed_angle.c", {**values, "arctangent": _horner(_ARCTANGENT, real)})


def near_arctangent(real: Real) -> str:
    """C text of atan(x) / x in `square`, up to x = 1, that is never less."""
    return _horner(_NEAR_ARCTANGENT, real, product="(square * {})")


def rough_sine(real: Real) -> str:
    """C text of sin(x) / x in `square`, up to a quarter turn."""
    return _horner(_ROUGH_SINE, real)


def _horner(coefficients: tuple[float, ...], real: Real, product: str = "square * {}") -> str:
    """C text of a polynomial in `square`, by Horner's rule."""
    *rest, last = (real.literal(c) for c in coefficients)
    text = last
    for c in reversed(rest):
        text = f"{c} + {product.format(text if text == last else f'({text})')}"
    return text
