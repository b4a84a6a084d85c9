"""Every joint type and motion of the mechanism format: the generated C compiles and passes its own
test.
"""

from __future__ import annotations

import pytest

from helpers import firmware_tools as tools
from helpers import joint_types
from helpers.gate import in_gate, in_gate_but
from helpers.inside import Options


@pytest.mark.slow
@pytest.mark.parametrize("real", in_gate(["float", "double"], ["float"]))
@pytest.mark.parametrize(
    "made",
    in_gate_but(
        joint_types.MADE,
        [
            joint_types.helical_actuated,
            joint_types.cylindrical_universal,
            joint_types.mixed_arm,
            joint_types.cylindrical,
            joint_types.five_joints,
            joint_types.seven_joints,
            joint_types.helical_passive,
            joint_types.rods_at_the_end,
            joint_types.eight_joints,
            joint_types.translation,
            joint_types.schoenflies,
            joint_types.planar_rods,
            joint_types.universal,
            joint_types.ball,
        ],
    ),
    ids=[made.__name__ for made in joint_types.MADE],
)
def test_joint_types_and_motions_compile_and_pass(made, real, tmp_path):
    mechanism = made()
    tools.write_untested(mechanism, tmp_path, Options(real))
    tools.passed(
        tools.built(
            "gcc", tmp_path, [f"{mechanism.name}.c", f"{mechanism.name}_test.c"], "test", "-O1"
        )
    )
    tools.built("gcc", tmp_path, [f"{mechanism.name}.c", "example_main.c"], "example", "-O1")
