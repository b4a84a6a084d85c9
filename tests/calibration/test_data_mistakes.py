"""Every mistake in the table of rules is named where a file has it, by its own rule, and none where
the readings are right.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import hexapod_log
from helpers.hexapods import matrices
from helpers.inside import (
    RULES,
    Case,
    Noise,
    Workspace,
    diagnose,
    diagnose_labels,
    euler_from_quaternion,
    quaternion_from_euler,
    random_configurations,
    simulate_readings,
)
from symkin import Measurements, Pose, Reading

MACHINE = hexapod_log.TRUTH
END, BASE = np.array([0.0, 0.0, 0.01]), np.array([0.0, 0.0, -0.02])


@pytest.fixture(scope="module")
def poses() -> Measurements:
    """Whole poses of the machine that the file describes."""
    return hexapod_log.unstated(hexapod_log.log(np.random.default_rng(2), 24))


def with_joints(change):
    return lambda m: replace(m, joints=change(m.joints.copy()))


def column_times(column, factor):
    def change(values):
        values[:, column] *= factor
        return values

    return change


def positions_only(change):
    return lambda m: replace(m, position=change(m.position.copy()), orientation=None)


def distances_in_millimetres(m):
    ends = m.position + matrices(m.orientation) @ END
    values = 1e3 * np.linalg.norm(ends - BASE, axis=1)
    return replace(
        m, position=None, orientation=None, readings=[Reading("distance", values, ends=(END, BASE))]
    )


def inclinations_exchanged(m):
    r = matrices(m.orientation)
    alpha, beta = np.arctan2(r[:, 2, 1], r[:, 2, 2]), -np.arcsin(r[:, 2, 0])
    return replace(m, position=None, orientation=None, inclination=np.column_stack([beta, alpha]))


WORLD = Pose([0.5, -0.3, 0.2], quaternion_from_euler(np.array([0.4, -0.7, 1.5]), "xyz"))
TARGET = Pose([0.01, 0.02, 0.08], quaternion_from_euler(np.array([0.3, 0.2, 1.2]), "xyz"))


HERE = Pose.identity()


def seen_from(m, world=HERE, target=HERE):
    """Poses of a target on the platform in a measuring frame."""
    seen = [world @ Pose(p[:3], p[3:]) @ target for p in m.poses]
    return replace(
        m,
        position=np.array([p.position for p in seen]),
        orientation=np.array([p.quaternion for p in seen]),
    )


MISTAKES = {
    "the joints never move": (
        with_joints(lambda q: np.tile(q[:1], (len(q), 1))),
        "the posture never changes",
    ),
    "all joints of a kind in another unit": (with_joints(lambda q: 1e3 * q), "too large"),
    "one joint in another unit": (
        with_joints(column_times(2, 1e-3)),
        "leg3 look a factor of 1000 too small",
    ),
    "two joint columns exchanged": (
        with_joints(lambda q: q[:, [0, 4, 2, 3, 1, 5]]),
        "columns leg2 and leg5 look exchanged",
    ),
    "the sign of a joint reversed": (
        with_joints(column_times(3, -1.0)),
        "the sign of leg4 looks reversed",
    ),
    "positions in another unit": (
        lambda m: replace(m, position=1e3 * m.position),
        "the positions look",
    ),
    "orientations of the base in the platform": (
        lambda m: replace(m, orientation=m.orientation * [1, -1, -1, -1]),
        "inverted",
    ),
    "quaternions with their scalar last": (
        lambda m: replace(m, orientation=np.roll(m.orientation, -1, axis=1)),
        "qw looks",
    ),
    "distances in another unit": (distances_in_millimetres, "the distances look"),
    "alpha and beta exchanged": (inclinations_exchanged, "alpha and beta look exchanged"),
    "joint columns in another order, with other signs": (
        with_joints(lambda q: q[:, [1, 2, 0, 3, 4, 5]]),
        "they seem to hold leg2, leg3, leg1",
    ),
    "poses in a left-handed frame": (
        lambda m: replace(
            m, position=m.position * [1, -1, 1], orientation=m.orientation * [1, -1, 1, -1]
        ),
        "left-handed frame (y reversed",
    ),
    "poses in another frame": (lambda m: seen_from(m, WORLD), "all,world.* would"),
    "poses of another target": (lambda m: seen_from(m, target=TARGET), "all,target.* would"),
    "poses of another target in another frame": (
        lambda m: seen_from(m, WORLD, TARGET),
        "all,world.*,target.* would",
    ),
    "joints a row off": (
        with_joints(lambda q: np.roll(q, 1, axis=0)),
        "the joint readings look one row late",
    ),
    "two position columns exchanged": (
        positions_only(lambda x: x[:, [2, 1, 0]]),
        "the columns x and z look exchanged",
    ),
    "position columns in another order": (
        positions_only(lambda x: x[:, [1, 2, 0]]),
        "x, y, z seem to stand in z, x, y",
    ),
    "the sign of a position column reversed": (
        positions_only(column_times(2, -1.0)),
        "the sign of z looks reversed",
    ),
    "one position column in metres": (
        positions_only(column_times(2, 1e-3)),
        "the readings of z look a factor of 1000 too small",
    ),
    "one position column in millimetres": (
        positions_only(column_times(0, 1e3)),
        "the readings of x look a factor of 1000 too large",
    ),
}


EULER_MISTAKES = {
    "Euler angles in another unit": ("ZYX", np.radians, "Euler angles look radians taken for"),
    "Euler angles of another sequence": ("XZX", np.copy, "XZX about moving axes"),
}
"""The sequence of the angles, what is done to them, and what is said of them under the header
ZYX.
"""


HEXAPOD = symkin.load("zhang2009")


@pytest.fixture(scope="module")
def hexapod() -> Measurements:
    """Whole poses of a machine whose sides are nearly alike."""
    rng, groups, noise = np.random.default_rng(5), np.full(24, -1), Noise(0.0, 0.0)
    made = random_configurations(Workspace.about(HEXAPOD), groups, noise, rng)
    return simulate_readings(HEXAPOD, made, groups, ("position", "orientation"), noise, rng)


LINKAGE = symkin.load("stephenson_six_bar")
ENCODERS = ("rocker", "output")


@pytest.fixture(scope="module")
def encoders() -> Measurements:
    """What encoders on the two rockers of a six-bar read."""
    rng, groups, noise = np.random.default_rng(4), np.full(12, -1), Noise(0.0, 0.0)
    made = random_configurations(Workspace.about(LINKAGE), groups, noise, rng)
    return simulate_readings(LINKAGE, made, groups, ENCODERS, noise, rng)


def with_readings(change):
    return lambda m: replace(m, readings=change(list(m.readings)))


MISTAKES_OF_ENCODERS = {
    "the sign of a reading reversed": (
        with_readings(lambda read: [read[0], replace(read[1], values=-read[1].values)]),
        "the sign of output looks reversed",
    ),
    "two encoders exchanged": (
        with_readings(
            lambda read: [
                replace(read[0], values=read[1].values),
                replace(read[1], values=read[0].values),
            ]
        ),
        "the columns rocker and output look exchanged",
    ),
    "a reading in another unit": (
        with_readings(lambda read: [replace(read[0], values=np.degrees(read[0].values)), read[1]]),
        "the readings of rocker look",
    ),
}


ARM = symkin.load("scara")
MISTAKES_OF_ARMS = {
    "the signs of all joints reversed": (with_joints(np.negative), "the signs of shoulder, elbow"),
    "angles of joints in radians": (
        with_joints(lambda q: np.where([c.is_angular for c in ARM.actuated], np.radians(q), q)),
        "look radians taken for degrees",
    ),
    "one joint in radians": (
        with_joints(column_times(0, np.pi / 180)),
        "the readings of shoulder look radians taken for degrees",
    ),
}


@pytest.fixture(scope="module")
def arm() -> Measurements:
    """Positions of an arm's tool."""
    rng, groups, noise = np.random.default_rng(6), np.full(24, -1), Noise(0.0, 0.0)
    made = random_configurations(Workspace.about(ARM), groups, noise, rng)
    return simulate_readings(ARM, made, groups, ("position",), noise, rng)


def test_right_positions_of_an_arm_are_not_suspected(arm: Measurements) -> None:
    assert diagnose(Case(ARM, arm)) == ()


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES_OF_ARMS)
def test_a_mistake_of_an_arms_joints_is_named_by_its_rule(arm: Measurements, mistake: str) -> None:
    """Radians that spread as degrees may, so that the readings alone do not show them."""
    spoil, words = MISTAKES_OF_ARMS[mistake]
    assert_named(Case(ARM, spoil(arm)), mistake, words)


def assert_named(case, mistake, words) -> None:
    """The spoilt readings are said to have the mistake, in a sentence of its own rule."""
    said = diagnose(case)
    assert any(words in sentence for sentence in said), said
    (find,) = [rules[mistake] for rules in RULES.values() if mistake in rules]
    assert any(words in sentence for sentence, _ in find(case))


@pytest.mark.slow
@pytest.mark.parametrize("mistake", EULER_MISTAKES)
def test_a_mistake_of_euler_angles_is_named_by_its_rule(poses: Measurements, mistake: str) -> None:
    """Angles that the header says to be degrees of ZYX, and are not; right ones are not
    suspected.
    """
    sequence, spoil, words = EULER_MISTAKES[mistake]
    assert diagnose(case_of_angles(poses, "ZYX", "ZYX", np.copy)) == ()
    assert_named(case_of_angles(poses, sequence, "ZYX", spoil), mistake, words)


@pytest.mark.slow
@pytest.mark.parametrize("hopeless", ["ZYX", "XYX", "ZYZ", "YXZ", "xzy"])
def test_a_unit_is_named_whichever_sequence_was_found(poses: Measurements, hopeless: str) -> None:
    """Where no sequence is named, radians under degrees fit all about equally badly: the unit is
    named whichever of them was taken.
    """
    case = case_of_angles(poses, "ZYX", hopeless, np.radians)
    assert "radians taken for degrees" in diagnose(replace(case, sought=True))[0]


def test_a_slip_of_one_angle_is_named(arm: Measurements) -> None:
    """A thousand times a joint's angles, which no unit of the header is."""
    for factor, how in ((1e3, "large"), (1e-3, "small")):
        spoilt = with_joints(column_times(1, factor))(arm)
        (said,) = diagnose(Case(ARM, spoilt))
        assert f"the readings of elbow look a factor of 1000 too {how}" in said


def test_a_mirrored_inclination_is_named(poses: Measurements) -> None:
    read = inclinations_exchanged(poses)
    mirrored = replace(read, inclination=read.inclination[:, ::-1] * [1.0, -1.0])
    (said, *_) = diagnose(Case(MACHINE, mirrored))
    assert "the sign of beta looks reversed" in said


def test_what_shrinks_everything_explains_nothing(arm: Measurements) -> None:
    """Millimetres under centimetres: divided by a thousand the positions, or one of their columns,
    would be nearer to the machine's, and still nowhere; nor is an origin far off another unit: it
    is that of another frame.
    """
    for factors in (10.0, np.array([10.0, 1.0, 1.0])):
        assert diagnose(Case(ARM, replace(arm, position=factors * arm.position))) == ()
    far = np.array([1e3 * ARM.characteristic_length, 0.0, 0.0])
    (said,) = diagnose(Case(ARM, replace(arm, position=arm.position + far)))
    assert "all,world.* would find" in said


@pytest.mark.parametrize("factor", [25.4, 1 / 25.4, 1e3, 1e-3])
def test_inches_are_told_from_other_units(arm: Measurements, factor: float) -> None:
    """Of positions, or of one of their columns, the one unit is named that they stand in."""
    words = f"a factor of {max(factor, 1 / factor):g} too {'large' if factor > 1 else 'small'}"
    for factors in (factor, np.array([factor, 1.0, 1.0])):
        (said,) = diagnose(Case(ARM, replace(arm, position=factors * arm.position)))
        assert words in said


def case_of_angles(m: Measurements, sequence: str, header: str, spoil) -> Case:
    """Angles of a sequence, spoilt, and read in that of the header."""
    angles = spoil(np.array(euler_from_quaternion(m.orientation.T, sequence))).T
    read = np.array(quaternion_from_euler(angles.T, header)).T
    return Case(MACHINE, replace(m, orientation=read), euler=angles, sequence=header)


def test_right_encoders_are_not_suspected(encoders: Measurements) -> None:
    assert diagnose(Case(LINKAGE, encoders)) == ()


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES_OF_ENCODERS)
def test_a_mistake_of_encoders_is_named_by_its_rule(encoders: Measurements, mistake: str) -> None:
    spoil, words = MISTAKES_OF_ENCODERS[mistake]
    assert_named(Case(LINKAGE, spoil(encoders)), mistake, words)


def test_right_readings_are_not_suspected(poses: Measurements) -> None:
    assert diagnose(Case(MACHINE, poses)) == ()


def test_every_rule_of_the_table_has_a_case_here() -> None:
    assert {name for stage, rules in RULES.items() if stage != "labels" for name in rules} == {
        *MISTAKES,
        *MISTAKES_OF_ENCODERS,
        *MISTAKES_OF_ARMS,
        *EULER_MISTAKES,
    }
    assert len(RULES["labels"]) == 1


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_by_its_rule(poses: Measurements, mistake: str) -> None:
    """The sentence is one of the rule's own, and is said of the file."""
    spoil, words = MISTAKES[mistake]
    assert_named(Case(MACHINE, spoil(poses)), mistake, words)


def test_a_cause_that_leaves_much_of_the_misfit_is_not_named(hexapod: Measurements) -> None:
    """Poses in a left-handed frame: the legs in another order left a quarter of the misfit, and
    were named.
    """
    spoil, words = MISTAKES["poses in a left-handed frame"]
    (said,) = diagnose(Case(HEXAPOD, spoil(hexapod)))
    assert words in said


def test_a_wrong_label_of_a_group_is_named() -> None:
    """One row with the label of another group, far from its own; right labels are not suspected."""
    rng, groups = np.random.default_rng(3), np.repeat([0, 1, 2], 6)
    wedges = np.radians([[0.0, 0.0], [12.0, 0.0], [0.0, 12.0]])
    noise = Noise(group=1e-4)
    held = wedges[groups] + noise.draw(noise.group, (len(groups), 2), rng)
    made = Workspace.about(MACHINE).draw(held, rng)
    data = simulate_readings(MACHINE, made, groups, (), noise, rng)
    assert diagnose_labels(Case(MACHINE, data)) == ()
    wrong = groups.copy()
    wrong[4] = 2
    assert (
        "posture 5 looks to be in the wrong group"
        in diagnose_labels(Case(MACHINE, replace(data, groups=wrong)))[0]
    )
