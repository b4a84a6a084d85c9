"""Machines as a factory calibrates them: arms with offsets of hundreds of metres along nearly
parallel axes that cancel, and hinges all but perpendicular to the slides that they carry.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import Options, write_folder
from helpers.samples import three_rps
from symkin import DHRow, DHTable, InputError, Mechanism, serial_arm_from_dh


def _calibrated():
    """Axes 2, 3 and 4 are parallel but for half a milliradian: their common normals lie 300 m along
    the axes.
    """
    rows = [
        DHRow("q1", d=0.1807, alpha=math.pi / 2 + 1e-4),
        DHRow("q2", d=297.7, a=-0.6127, alpha=5e-4),
        DHRow("q3", d=-298.1, a=-0.57155, alpha=-5e-4),
        DHRow("q4", d=0.57415, alpha=math.pi / 2),
        DHRow("q5", d=0.11985, alpha=-math.pi / 2),
        DHRow("q6", d=0.11655),
    ]
    return serial_arm_from_dh("calibrated", DHTable("standard", rows), length_unit="m")


def test_the_size_is_that_of_the_machine():
    assert 1.0 < _calibrated().characteristic_length < 1.5


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("real", ["float", "double"])
def test_code_of_a_calibrated_arm_passes_its_test(real, tmp_path):
    tools.write_untested(_calibrated(), tmp_path, Options(real))
    tools.passed(tools.built("gcc", tmp_path, ["calibrated.c", "calibrated_test.c"], "test", "-O1"))


def test_a_struct_of_such_numbers_in_float_is_refused(tmp_path):
    """A float resolves 300 m to 0.03 mm, which is then the arm's error."""
    with pytest.raises(InputError, match="over 100 times its size"):
        write_folder(_calibrated(), tmp_path, Options("float", geometry="struct"))


def _with_hinges_askew(by: float) -> Mechanism:
    """A 3-RPS whose hinges are not quite perpendicular to their slides."""
    nominal = three_rps()
    limbs = [
        replace(
            limb,
            joints=[
                replace(j, axis=np.add(j.axis, by * np.array([0.3, -0.2, 1.0])))
                if j.type == "R"
                else j
                for j in limb.joints
            ],
        )
        for limb in nominal.limbs
    ]
    return replace(nominal, name="askew", limbs=limbs)


@pytest.mark.slow
@pytest.mark.parametrize("real", in_gate(["float", "double"], ["double"]))
@pytest.mark.parametrize("by", in_gate([1e-4, 3e-3, 3e-2], [3e-3]))
def test_code_of_limbs_whose_hinge_is_all_but_perpendicular_passes_its_test(real, by, tmp_path):
    """A row along the hinge would tell the slide, divided by the small angle: its digits are
    lost.
    """
    tools.write_untested(_with_hinges_askew(by), tmp_path, Options(real))
    tools.passed(tools.built("gcc", tmp_path, ["askew.c", "askew_test.c"], "test", "-O1"))
