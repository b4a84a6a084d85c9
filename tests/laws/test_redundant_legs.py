"""Platforms on more than six rods: every pose that has all lengths, and only these."""

import numpy as np
import pytest

import symkin
from helpers.inside import Options, folder_files
from symkin import InputError


def _rotation(q):
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _points(count, seed, *, flat=False):
    """Joint centres on the base and on the platform, mm, about circles."""
    rng = np.random.default_rng(seed)
    turn = 2 * np.pi * np.arange(count) / count
    base = np.column_stack([250 * np.cos(turn), 250 * np.sin(turn), 0 * turn]) + rng.uniform(
        -30, 30, (count, 3)
    )
    turn = turn + 0.5 * (-1) ** np.arange(count)
    platform = np.column_stack([120 * np.cos(turn), 120 * np.sin(turn), 0 * turn]) + rng.uniform(
        -20, 20, (count, 3)
    )
    return (base * [1, 1, 0], platform * [1, 1, 0]) if flat else (base, platform)


def _machine(base, platform, name="rods"):
    limbs = [
        symkin.RodLimb(f"leg{i}", base=tuple(b), platform=tuple(p))
        for i, (b, p) in enumerate(zip(base, platform, strict=True))
    ]
    return symkin.Mechanism(
        name, limbs, platform_position=(0, 0, 200), length_unit="mm", angle_unit="deg"
    )


def _lengths(base, platform, position, quaternion):
    q = np.asarray(quaternion) / np.linalg.norm(quaternion)
    return np.linalg.norm(np.asarray(position) + platform @ _rotation(q).T - base, axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("count", [7, 8, 24])
def test_the_pose_that_made_the_lengths_is_found(count):
    """Lengths of a random pose, by the formula |p + R a - b|: the direct problem has that pose, and
    one that has all.
    """
    base, platform = _points(count, count)
    position, quaternion = (25.0, -31.0, 230.0), np.array([0.95, 0.1, -0.2, 0.15])
    lengths = _lengths(base, platform, position, quaternion)
    found = symkin.modes(_machine(base, platform), joints=lengths.tolist())
    assert found.completeness == "probability one"
    for mode in found:
        np.testing.assert_allclose(
            _lengths(base, platform, mode.position, mode.pose.quaternion), lengths, atol=1e-9
        )
    assert len(found) == found.complex_count == 1
    np.testing.assert_allclose(found[0].position, position, atol=1e-7)
    assert abs(abs(found[0].pose.quaternion @ quaternion / np.linalg.norm(quaternion)) - 1) < 1e-12
    assert not found[0].certified
    assert any(f"of {count} distances six" in note for note in found.notes)


def test_a_flat_machine_has_the_mirror_image_too():
    """With all centres in two planes, the pose reflected at the base's plane has the same eight
    lengths.
    """
    base, platform = _points(8, 1, flat=True)
    position, quaternion = np.array([25.0, -31.0, 230.0]), np.array([0.95, 0.1, -0.2, 0.15])
    lengths = _lengths(base, platform, position, quaternion)
    found = symkin.modes(_machine(base, platform), joints=lengths.tolist())
    heights = sorted(mode.position[2] for mode in found)
    np.testing.assert_allclose(heights, [-230.0, 230.0], atol=1e-6)


@pytest.mark.slow
def test_lengths_that_contradict_each_other_have_no_pose():
    """One of eight rods is 1 mm too long: the six that agree do not decide."""
    base, platform = _points(8, 2)
    lengths = _lengths(base, platform, (0, 0, 220), (1, 0.1, 0, 0))
    for k in range(8):
        wrong = lengths + np.eye(8)[k]
        assert len(symkin.modes(_machine(base, platform), joints=wrong.tolist())) == 0


def test_firmware_says_why_it_is_not_for_joints_that_must_agree():
    base, platform = _points(7, 3)
    with pytest.raises(
        InputError, match="7 actuated joints move 6 freedoms, so that their values must agree"
    ):
        folder_files(_machine(base, platform), Options())


def test_a_planar_machine_of_four_legs_is_sampled_with_the_reason():
    """Redundant legs that are no rods: the search for generic solutions, which there are none of,
    is not begun.
    """
    limbs = []
    for i, turn in enumerate(2 * np.pi * np.arange(4) / 4 + 0.1 * np.arange(4)):
        b = np.round([200 * np.cos(turn), 200 * np.sin(turn), 0], 6)
        p = np.round([60 * np.cos(turn + 0.7), 60 * np.sin(turn + 0.7), 0], 6)
        joints = [
            symkin.Joint(f"a{i}", "R", point=tuple(b), axis=(0, 0, 1)),
            symkin.Joint(f"s{i}", "P", axis=tuple(p - b), actuated=True),
            symkin.Joint(f"c{i}", "R", point=tuple(p), axis=(0, 0, 1)),
        ]
        limbs.append(symkin.Limb(f"leg{i}", joints))
    machine = symkin.Mechanism(
        "planar",
        limbs,
        platform_position=(0, 0, 0),
        motion="planar",
        length_unit="mm",
        angle_unit="deg",
    )
    found = symkin.modes(machine, starts=300)
    assert found.completeness == "sampled"
    assert any(
        "values of the actuated joints must agree with each other: 4 of them for 3 freedoms" in note
        for note in found.notes
    )
    assert min(np.linalg.norm(mode.position) for mode in found) < 1e-6
    assert not any("operation modes" in note for note in found.notes)
    home = found[0].joints
    apart = [home[f"s{i}"] + 0.05 * (i == 3) for i in range(4)]
    with pytest.raises(
        symkin.SolveError, match=r"close to within .* must agree with each other: 4"
    ):
        symkin.solve(machine, joints=apart)


# --- large numbers --------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    "which", ["all", pytest.param("one point", marks=pytest.mark.long), "position"]
)
def test_coordinates_of_1e150_make_no_warnings(which):
    """Warnings are errors here: whatever the verbs answer or refuse, they say it themselves."""
    base, platform = _points(6, 4)
    position = np.array([0.0, 0.0, 200.0])
    if which == "all":
        base, platform, position = base * 1e150, platform * 1e150, position * 1e150
    elif which == "one point":
        platform[0, 0] = 1e150
    else:
        position[1] = 1e150
    limbs = [
        symkin.RodLimb(f"leg{i}", base=tuple(b), platform=tuple(p))
        for i, (b, p) in enumerate(zip(base, platform, strict=True))
    ]
    machine = symkin.Mechanism(
        "far", limbs, platform_position=tuple(position), length_unit="mm", angle_unit="deg"
    )
    for verb in (
        lambda: symkin.modes(machine),
        lambda: symkin.modes(machine, pose=(*position, 1, 0, 0, 0)),
        lambda: symkin.solve(machine, check=False),
        lambda: symkin.solve(machine, solver="ipopt", check=False),
        lambda: symkin.singularity(machine),
        lambda: symkin.jacobian(machine),
    ):
        try:
            verb()
        except symkin.SymkinError as error:
            assert str(error)  # noqa: PT017
