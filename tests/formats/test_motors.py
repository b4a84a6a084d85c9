"""What files tell of motors is what MuJoCo and Pinocchio make of them, every format that holds it
gives it back, and the verb `transmission` takes it where nothing else is told.
"""

from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.needed import Later, needs

mujoco, pinocchio = Later("mujoco"), Later("pinocchio")
MJCF = """<mujoco><compiler angle="radian" autolimits="true"/><worldbody>
<body name="a"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
  <joint name="free" axis="0 0 1"/>
  <body name="b" pos="1 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
    <joint name="geared" axis="0 0 1" armature="0.25"/>
    <body name="c" pos="1 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <joint name="held" axis="0 0 1" actuatorfrcrange="-5 7"/>
      <body name="d" pos="1 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
        <joint name="servo" type="slide" axis="1 0 0"/>
      </body></body></body></body></worldbody>
<actuator>
  <motor joint="geared" gear="-3" ctrlrange="-2 4" forcerange="-1.5 9" armature="0.01"/>
  <motor joint="held" gear="2" ctrlrange="-9 3"/><motor joint="held" ctrlrange="-1 0.5"/>
  <position joint="servo" kp="100" ctrlrange="-1 1" forcerange="-8 8"/>
</actuator></mujoco>"""
URDF = """<robot name="pair"><link name="base"/><link name="one"/><link name="two"/>
<joint name="first" type="revolute"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/>
  <limit lower="-1" upper="1" effort="12.5" velocity="3"/></joint>
<joint name="second" type="prismatic"><parent link="one"/><child link="two"/><axis xyz="1 0 0"/>
  <limit lower="-1" upper="1" effort="0" velocity="1e16"/></joint>
<transmission name="t"><joint name="first"/><actuator name="m"><mechanicalReduction>50
</mechanicalReduction><drake:rotor_inertia value="2e-5"/></actuator></transmission>
</robot>"""


def motors(path: Path) -> dict[str, symkin.Motor | None]:
    return {joint.name: joint.motor for joint in symkin.load(path).all_joints}


def written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


@needs("mujoco")
def test_mjcf_is_what_mujoco_gives(tmp_path):
    """The range of each joint's force is that of MuJoCo's own forces over all controls, the
    armature what its mass matrix has beyond that of a model without.
    """
    found = motors(written(tmp_path / "robot.xml", MJCF))
    assert found["free"] is None
    model = mujoco.MjModel.from_xml_string(MJCF)
    data, seen = mujoco.MjData(model), []
    for control in np.random.default_rng(0).choice([-50.0, 50.0], (64, model.nu)):
        data.ctrl[:] = control
        mujoco.mj_forward(model, data)
        seen.append(data.qfrc_actuator.copy())
    low, high = np.min(seen, axis=0), np.max(seen, axis=0)
    for k, name in enumerate(("geared", "held", "servo"), start=1):
        assert found[name].effort == pytest.approx((low[k], high[k])), name
    bare = mujoco.MjModel.from_xml_string(
        MJCF.replace('armature="0.25"', "").replace('armature="0.01"', "")
    )
    without = mujoco.MjData(bare)
    mujoco.mj_forward(bare, without)
    gained = {name: 0.0 if m is None else m.armature or 0.0 for name, m in found.items()}
    diagonal = (data.M - without.M)[model.M_rowadr + model.M_rownnz - 1]
    assert diagonal == pytest.approx(list(gained.values()))


@needs("pinocchio")
def test_urdf_is_what_pinocchio_reads(tmp_path):
    """Efforts and speeds are Pinocchio's, but those that stand for none; a rotor counts with the
    square of its gears.
    """
    path = written(tmp_path / "pair.urdf", URDF)
    found, model = motors(path), pinocchio.buildModelFromUrdf(str(path))
    first = found["first"]
    assert first.effort == (-model.effortLimit[0], model.effortLimit[0])
    assert first.speed == model.velocityLimit[0]
    assert first.armature == pytest.approx(2e-5 * 50**2)
    assert found["second"] is None


@needs("mujoco")
@pytest.mark.parametrize("suffix", [".toml", ".xml", ".urdf", ".sdf"])
def test_every_format_gives_motors_back(suffix, tmp_path):
    """What a format holds of a motor is there again after it was written: MJCF has no speeds,
    URDF and SDF no inertias and one number for both directions.
    """
    robot = symkin.load(written(tmp_path / "robot.urdf", URDF))
    output = tmp_path / f"again{suffix}"
    symkin.convert(tmp_path / "robot.urdf", output)
    told = {joint.name: joint.motor for joint in robot.all_joints}["first"]
    again = motors(output)["first"]
    assert again.effort == told.effort
    assert again.speed == (None if suffix == ".xml" else told.speed)
    assert again.armature == (told.armature if suffix in (".toml", ".xml") else None)
    assert motors(output)["second"] is None


@pytest.mark.parametrize(
    ("motor", "sentence"),
    [
        ("effort = [3, -3]", "effort = [3, -3]; the lower end comes first"),
        ("speed = 0", "speed = 0; a number above 0"),
        ("armature = -1", "armature = -1; a number above 0"),
        ("torque = 1", "torque"),
    ],
)
def test_motors_that_cannot_be(motor, sentence, tmp_path):
    """A motor in a mechanism file that means nothing is refused in one line that names it."""
    text = symkin.load("four_bar").to_toml().replace("actuated = true", f"motor = {{{motor}}}")
    with pytest.raises(symkin.MechanismError) as caught:
        symkin.load(written(tmp_path / "bad.toml", text))
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("unit", ["m", "mm"])
def test_transmission_takes_the_files_motors(unit, tmp_path):
    """Without options torques, speeds and inertias are the file's, whatever its length unit: in
    metres those of the options, and power in millimetres is a thousand times as many.
    """
    text = symkin.load("four_bar").to_toml()
    told = text.replace(
        "actuated = true",
        "actuated = true\nmotor = {effort = [-25, 20], speed = 3, armature = 0.001}",
    )
    told = told.replace('length_unit = "mm"', f'length_unit = "{unit}"')
    machine = symkin.load(written(tmp_path / "four_bar.toml", told))
    assert machine.length_unit == unit
    found = symkin.transmission(machine, ["crank"], ["follower"])
    scale = 1.0 if unit == "m" else 1000.0
    assert found.data.torque_limits == pytest.approx(np.array([[-25.0, 20.0]]) * scale)
    assert found.data.speed_limits.tolist() == [[-3.0, 3.0]]
    assert found.data.inertias == pytest.approx([0.001 * scale])
    assert not found.data.untold
    other = symkin.transmission(machine, ["crank"], ["follower"], torque_limits=1.0)
    assert other.data.torque_limits.tolist() == [[-1.0, 1.0]]
    assert other.data.of_file == ("speed_limits", "inertia")
