"""A sweep's points have the modes that `symkin.modes` finds, whatever their neighbours."""

import math

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import COMPLETENESS, build_problem, make_finder, modes_at_need, multiply, parse
from helpers.samples import Z, delta, five_bar, hexapod, random_mechanism, three_rps
from helpers.sweep_points import tables_of
from symkin import Joint, Limb, Mechanism, Pose


def enumerated(mechanism, kind, points, **options):
    chosen = {"starts": 300, "seed": 0, "certify": False} | options
    return tables_of(make_finder(build_problem(mechanism, kind), **chosen), points)


def modes_of(found, i):
    """Rows (mode, position and quaternion and joints) of point i."""
    begin = int(np.maximum(found.count, 0)[:i].sum())
    part = slice(begin, begin + int(found.count[i]))
    listed, joints = found.listed, found.joints_and_points[0]
    return np.hstack([listed.position[part], listed.quaternion[part], joints[part]])


def check_same(mechanism, kind, points, tolerance=1e-9):
    """Counts, and modes in order to `tolerance` of the size (angles apart by whole turns are
    one).
    """
    found, total = enumerated(mechanism, kind, points), 0
    for i, point in enumerate(points):
        alone = modes_at_need(mechanism, **point, starts=300)
        assert found.count[i] == len(alone), (i, point)
        total += len(alone)
        expected = [
            [*s.position, *s.quaternion, *np.hstack(list(s.printed_joints.values()))] for s in alone
        ]
        if len(alone):
            difference = np.abs(modes_of(found, i) - np.array(expected))
            assert difference.max() < tolerance * max(1.0, mechanism.characteristic_length)
    assert total > 0
    return found


def joints_about(mechanism, count, spread, seed=0):
    rng = np.random.default_rng(seed)
    example = mechanism.example
    base = np.array(
        example.joints
        if example and example.joints
        else [mechanism.angle_out(c.reference[0]) for c in mechanism.actuated]
    )
    return [{"joints": list(base + spread * rng.uniform(-1, 1, len(base)))} for _ in range(count)]


def poses_about(mechanism, count, length, turn=0.2, seed=0):
    rng, reference = np.random.default_rng(seed), mechanism.reference_pose
    found = []
    for _ in range(count):
        away = Pose.from_euler(length * rng.uniform(-1, 1, 3), turn * rng.uniform(-1, 1, 3), "XYZ")
        quaternion = multiply(away.quaternion, reference.quaternion)
        found.append(
            {"pose": Pose(np.asarray(away.position) + reference.position, np.asarray(quaternion))}
        )
    return found


@pytest.mark.parametrize(("name", "spread"), [("zhang2009", 40.0), ("zhao2000", 15.0)])
def test_direct_problem_as_modes(name, spread):
    """All modes at random inputs are those of `symkin.modes`, in the same order."""
    mechanism = symkin.load(name)
    found = check_same(mechanism, "direct", joints_about(mechanism, 6, spread))
    assert found.listed.residual.max() < 1e-9 * mechanism.characteristic_length


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "length", "turn"),
    [
        pytest.param("zhang2009", 30.0, 0.3, marks=pytest.mark.long),
        ("zhao2000", 20.0, 0.0),
        pytest.param("gluon_6l3", 200.0, 1.5, marks=pytest.mark.long),
    ],
)
def test_inverse_problem_as_modes(name, length, turn):
    """All modes at random poses are those of `symkin.modes`, in the same order."""
    mechanism = symkin.load(name)
    check_same(mechanism, "inverse", poses_about(mechanism, 5, length, turn))


def test_planar_mechanism_as_modes():
    """A planar five-bar at inputs in and out of reach."""
    check_same(five_bar(), "direct", joints_about(five_bar(), 4, 40.0))


@pytest.mark.slow
@pytest.mark.parametrize(
    "limbs", in_gate([["SPS"] * 6, ["rUS", "rUS", "rUS", "pUS", "SPS", "SPS"]], [["SPS"] * 6])
)
def test_random_platforms_as_modes(limbs):
    """Random spatial platforms on limbs of mixed types."""
    mechanism = random_mechanism(np.random.default_rng(5), limbs)
    check_same(
        mechanism, "direct", joints_about(mechanism, 4, 3.0 if limbs[0] == "SPS" else 0.02), 1e-7
    )


def test_arms_that_touch_the_border_of_their_reach():
    """A planar arm of links 2 and 1: two working modes within 1 < r < 3, none outside, one where it
    is stretched.
    """
    joints = [
        Joint("a", "R", (0, 0, 0), Z, actuated=True),
        Joint("b", "R", (2, 0, 0), Z, actuated=True),
    ]
    limb = Limb("limb", [*joints, Joint("c", "R", (3, 0, 0), Z)])
    mechanism = Mechanism("two_links", [limb], platform_position=(3, 0, 0), motion="planar")
    radii = [0.9, 1 + 1e-3, 2.0, 3 - 1e-6, 3 - 1e-10, 3.0, 3 + 1e-3]
    points = [
        {
            "pose": Pose(
                np.array([r * math.cos(0.3), r * math.sin(0.3), 0.0]), np.array([1.0, 0, 0, 0])
            )
        }
        for r in radii
    ]
    found = enumerated(mechanism, "inverse", points)
    expected = [len(modes_at_need(mechanism, **p, starts=300)) for p in points]
    assert found.count.tolist() == expected
    assert found.count[[0, 1, 2, 3, 6]].tolist() == [0, 2, 2, 2, 0]


def test_results_do_not_depend_on_neighbours():
    """A point alone, in another order and among others has the same modes: the same bits where
    paths are tracked by compiled code; NumPy's batches may differ in last digits, for which reason
    a sweep's chunks are fixed.
    """
    mechanism = symkin.load("zhang2009")
    points = joints_about(mechanism, 30, 40.0, seed=2)
    together, turned = (
        enumerated(mechanism, "direct", points),
        enumerated(mechanism, "direct", points[::-1]),
    )
    engine = make_finder(
        build_problem(mechanism, "direct"), starts=300, seed=0, certify=False
    ).engine
    tolerance = 0.0 if engine == "compiled C" else 1e-9 * mechanism.characteristic_length
    for i in range(0, 30, 3):
        alone = modes_of(enumerated(mechanism, "direct", [points[i]]), 0)
        for other in (modes_of(together, i), modes_of(turned, 29 - i)):
            assert alone.shape == other.shape
            assert np.abs(alone - other).max(initial=0.0) <= tolerance


def test_forward_kinematics_of_an_arm():
    """A serial arm has one mode at any joints, proved."""
    mechanism = symkin.load("gluon_6l3")
    found = check_same(mechanism, "direct", joints_about(mechanism, 5, 90.0))
    assert set(found.completeness) == {COMPLETENESS.index("proved")}


def test_problems_that_are_sampled_say_so():
    """A helical joint leaves no paths: completeness is 'sampled', and no number of unresolved paths
    is claimed.
    """
    joints = [
        Joint("a", "R", (0, 0, 0), Z),
        Joint("h", "H", (40, 0, 0), Z, pitch=5.0),
        Joint("b", "R", (70, 20, 0), Z),
    ]
    other = Limb("slide", [Joint("p", "P", (0, 0, 0), Z, actuated=True)])
    mechanism = Mechanism("screw", [Limb("limb", joints), other], platform_position=(90, 0, 0))
    points = [{"joints": [v]} for v in (0.0, 2.0)]
    found = enumerated(mechanism, "direct", points)
    assert set(found.completeness) == {COMPLETENESS.index("sampled")}
    assert found.count.tolist() == [len(modes_at_need(mechanism, **p, starts=300)) for p in points]
    assert (found.unresolved == -1).all()


def test_poses_off_the_motion():
    """A pose that a restricted platform cannot take has no mode, and its neighbours keep theirs."""
    mechanism = symkin.load("zhao2000")
    tilt = Pose.from_euler(np.array([0.0, 0.0, 100.0]), [0.2, 0.0, 0.0], "XYZ")
    found = enumerated(
        mechanism,
        "inverse",
        [{"pose": Pose(np.array([1.0, 2.0, 99.0]), np.array([1.0, 0, 0, 0]))}, {"pose": tilt}],
    )
    assert found.count.tolist() == [8, 0]
    assert [COMPLETENESS[c] for c in found.completeness] == ["probability one", "off the motion"]


@pytest.mark.slow
@pytest.mark.parametrize(("mechanism", "kind"), [(delta(), "inverse"), (three_rps(), "direct")])
def test_points_with_more_modes_than_can_be_listed(monkeypatch, mechanism, kind):
    """Such a point has the count -1 and says so, whether blocks or the branches of one block
    multiply; nothing is raised.
    """
    for module in ("assembly.tree", "assembly.by_groups"):
        monkeypatch.setattr(f"symkin.{module}.MOST_MODES", 0)
    points = (
        joints_about(mechanism, 2, 1.0) if kind == "direct" else poses_about(mechanism, 2, 1.0, 0.0)
    )
    found = enumerated(mechanism, kind, points)
    assert found.count.tolist() == [-1, -1]
    assert {COMPLETENESS[c] for c in found.completeness} == {"too many to list"}
    assert not len(found.listed)


def test_sets_that_are_not_isolated():
    """Equal base and platform on parallel legs: a sphere of translations. No mode of it is counted,
    nothing is claimed.
    """
    ends = np.random.default_rng(0).uniform(-100, 100, (6, 3))
    found = enumerated(hexapod(ends, ends), "direct", [{"joints": [150.0] * 6}])
    assert found.continuum.tolist() == [True]
    assert [COMPLETENESS[c] for c in found.completeness] == ["incomplete"]


def test_certificates_where_asked():
    """With certificates every mode of a regular point is proved; without, none is said to be."""
    mechanism = symkin.load("zhang2009")
    points = joints_about(mechanism, 2, 1.0)
    proved, plain = (
        enumerated(mechanism, "direct", points, certify=True),
        enumerated(mechanism, "direct", points),
    )
    assert (proved.listed.certified == 1).all()
    assert (proved.listed.radius < 1e-6).all()
    assert (plain.listed.certified == -1).all()
    assert np.allclose(
        proved.listed.position, plain.listed.position, atol=1e-9 * mechanism.characteristic_length
    )


def test_limits_are_flags():
    """Modes outside limits are listed and flagged; without limits nothing is said."""
    arm = symkin.load("gluon_6l3")
    unlimited = enumerated(arm, "direct", joints_about(arm, 2, 1.0))
    assert (unlimited.listed.within_limits == -1).all()
    text = (
        symkin.load("zhang2009")
        .to_toml()
        .replace('name = "leg1"', 'name = "leg1"\nlimits = [100.0, 150.0]')
    )
    limited = parse(text)
    legs = list(limited.example.joints)
    found = enumerated(limited, "direct", [{"joints": legs}, {"joints": [160.0, *legs[1:]]}])
    first = int(found.count[0])
    assert first > 0
    assert (found.listed.within_limits[:first] == 1).all()
    assert len(found.listed.within_limits) > first
    assert (found.listed.within_limits[first:] == 0).all()
