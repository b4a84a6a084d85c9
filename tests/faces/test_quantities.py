"""Quantities of the command line: numbers with units, and standard deviations that cannot be
meant.
"""

from __future__ import annotations

import math

import pytest

import symkin
from helpers.inside import noise_quantity, quantity
from symkin import InputError

METRES = {"um": 1e-6, "mm": 1e-3, "m": 1.0, "in": 0.0254}


def machine(length_unit: str, angle_unit: str) -> symkin.Mechanism:
    """An arm of two hinges 0.8 m apart."""
    far = 0.8 / METRES[length_unit]
    joints = [
        symkin.Joint(f"q{k}", "R", [x, 0, 0], [0, 0, 1], actuated=True)
        for k, x in enumerate((0.0, far))
    ]
    return symkin.Mechanism(
        "arm",
        [symkin.Limb("arm", joints)],
        platform_position=(2 * far, 0, 0),
        serial=True,
        length_unit=length_unit,
        angle_unit=angle_unit,
    )


@pytest.mark.parametrize("own", ["mm", "m"])
@pytest.mark.parametrize("unit", METRES)
def test_lengths_are_of_the_mechanisms_unit(unit: str, own: str) -> None:
    mechanism = machine(own, "rad")
    found = quantity(f"3.5{unit}", "length", mechanism, "noise")
    assert found * METRES[own] == pytest.approx(3.5 * METRES[unit], rel=1e-12)
    assert quantity("3.5", "length", mechanism, "noise") == 3.5


@pytest.mark.parametrize("own", ["deg", "rad"])
def test_angles_are_radians(own: str) -> None:
    mechanism = machine("mm", own)
    assert quantity("90deg", "angle", mechanism, "noise") == pytest.approx(math.pi / 2)
    assert quantity("0.5rad", "angle", mechanism, "noise") == 0.5
    plain = quantity("1", "angle", mechanism, "noise")
    assert plain == pytest.approx(math.radians(1.0) if own == "deg" else 1.0)


def test_noise_beyond_a_tenth_of_the_size_is_refused() -> None:
    """And of a radian; what is just below is taken."""
    mechanism = machine("mm", "deg")
    tenth = 0.1 * mechanism.characteristic_length
    for kind, most in (("length", f"{tenth:.9g}mm"), ("angle", "0.1rad")):
        number = float(most.rstrip("mrad"))
        unit = most.lstrip("0123456789.")
        assert noise_quantity(f"{0.99 * number:.9g}{unit}", kind, mechanism, "noise") > 0
        with pytest.raises(InputError, match="check the unit"):
            noise_quantity(f"{1.01 * number:.9g}{unit}", kind, mechanism, "noise")
    for text in ("-1mm", "1deg", "1 furlong", "nan", "1e999mm", ""):
        with pytest.raises(InputError, match="a number from 0 with a unit of length is needed"):
            quantity(text, "length", mechanism, "noise")
