"""Laws of machines whose limbs are of unlike kinds, held against a closure in plain NumPy and its
roots from random starts.
"""

import tomllib

import numpy as np
import pytest

import symkin
from helpers.inside import build_problem, redundant_rows, structure_groups
from oracle.plain_closure import PlainMechanism
from oracle.plain_search import features, solutions
from symkin import InputError, Joint, Limb, Mechanism, Modes, Solution

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def plain_of(mechanism: Mechanism) -> PlainMechanism:
    return PlainMechanism(tomllib.loads(mechanism.to_toml()))


def same_lists(mechanism: Mechanism, known: np.ndarray, found: Modes, starts: int = 120) -> bool:
    """The modes are the regular roots of the plain closure, one to one, with the coordinates at
    places of `found` as given.
    """
    plain = plain_of(mechanism)
    role = "actuated" if found.problem.name == "direct" else "pose"
    free = [i for i, n in enumerate(plain.numbers) if n.role != role]
    roots = solutions(plain, known, free, starts, np.random.default_rng(0))
    assert all(root.regular for root in roots)
    names = set(found[0].values)
    places = [i for i, n in enumerate(plain.numbers) if n.name in names]
    theirs = features(plain, np.array([root.x for root in roots]), places)
    ours = features(plain, np.array([vector(plain, mode) for mode in found]), places)
    apart = np.max(np.abs(theirs[:, None] - ours[None]), axis=2) < 1e-6
    return bool(apart.any(axis=1).all() and apart.any(axis=0).all())


def vector(plain: PlainMechanism, mode: Solution) -> np.ndarray:
    x = plain.with_pose(plain.reference[None], mode.position, mode.quaternion)[0]
    for number, place in zip(plain.numbers, plain.slices, strict=True):
        if number.role != "pose" and number.name in mode.values:
            x[place] = mode.values[number.name]
    return x


def us_limbs(centre: list[Joint], motion: str = "spatial") -> Mechanism:
    """Two limbs U P S with driven slides beside a limb of other joints."""
    limbs = [Limb("centre", centre)]
    for k, (foot, end) in enumerate(
        [((90, 10, 0), (30, 5, 95)), ((-20, 80, 5), (-10, 40, 110))], start=1
    ):
        along = np.subtract(end, foot) / np.linalg.norm(np.subtract(end, foot))
        first = np.cross(along, X)
        joints = [
            Joint(f"u{k}", "U", foot, first, np.cross(along, first)),
            Joint(f"p{k}", "P", foot, along, actuated=True),
        ]
        limbs.append(Limb(f"limb{k}", [*joints, Joint(f"s{k}", "S", end)]))
    return Mechanism("us_limbs", limbs, platform_position=(0, 0, 100), motion=motion)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    ("centre", "motion"),
    [
        ([Joint("r", "R", (0, 0, 0), X), Joint("p", "P", (0, 0, 0), Z)], "spatial"),
        ([Joint("a", "R", (0, 0, 100), X), Joint("b", "R", (0, 0, 100), Y)], "spherical"),
        ([Joint("a", "R", (0, 0, 100), X), Joint("b", "R", (0, 0, 100), Y)], "spatial"),
    ],
    ids=["a passive slide", "spherical", "spherical limb, spatial"],
)
def test_limbs_made_distances_stand_beside_limbs_that_keep_passive_joints(centre, motion):
    """The angles of universal joints that a distance replaced come back at every pose, with all
    their combinations.
    """
    machine = us_limbs(centre, motion)
    found = symkin.modes(machine, joints=[4.0, -3.0])
    plain = plain_of(machine)
    known = plain.reference.copy()
    for name, value in (("p1", 4.0), ("p2", -3.0)):
        known[plain.slices[plain.names.index(name)]] = value
    assert found.completeness in ("proved", "probability one")
    assert same_lists(machine, known, found)


def spherical_rrr(motion: str) -> Mechanism:
    """Three limbs of three axes through the platform's origin."""
    rng = np.random.default_rng(3)
    axes = rng.normal(size=(3, 3, 3))
    limbs = [
        Limb(
            f"limb{k}",
            [
                Joint(f"{letter}{k}", "R", (0, 0, 0), axes[k, i], actuated=i == 0)
                for i, letter in enumerate("abc")
            ],
        )
        for k in range(3)
    ]
    return Mechanism("spherical_rrr", limbs, motion=motion)


@pytest.mark.slow
@pytest.mark.long
def test_spherical_machines_need_no_declared_motion():
    """With joint points and platform origin in one point, modes are those of the declared motion:
    eight at most (Gosselin 1994), the position zero.
    """
    declared = symkin.modes(spherical_rrr("spherical"), joints=[0.1, -0.1, 0.05])
    free = symkin.modes(spherical_rrr("spatial"), joints=[0.1, -0.1, 0.05])
    assert declared.complex_count == free.complex_count == 8
    assert len(declared) == len(free) > 0
    for a, b in zip(declared, free, strict=True):
        assert np.allclose(a.rotation, b.rotation, atol=1e-9)
        assert np.allclose(b.position, 0.0, atol=1e-12)


ARMS = {
    "P P": [("P", X), ("P", Y)],
    "R": [("R", Z)],
    "P P R": [("P", X), ("P", Y), ("R", Z)],
    "P P P": [("P", X), ("P", (0.6, 0.8, 0.0)), ("P", Z)],
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_arms_whose_joints_do_not_meet_in_a_row_have_their_one_inverse(name):
    """The joints that made a pose are its only mode, also where each of them is told by rows of its
    own.
    """
    spec = ARMS[name]
    joints = [
        Joint(f"q{k}", kind, (10.0 * k, 3.0, 0.0), axis, actuated=True)
        for k, (kind, axis) in enumerate(spec)
    ]
    arm = Mechanism("arm", [Limb("arm", joints)], serial=True, platform_position=(50.0, 20.0, 10.0))
    values = [0.3 * (k + 1) for k in range(len(spec))]
    found = symkin.modes(arm, pose=symkin.solve(arm, joints=values).solution.pose)
    assert len(found) == 1
    assert np.allclose(found[0].actuated_values, values)


def test_solutions_that_further_rows_of_a_limb_refuse_are_not_counted():
    """At a pose the angle of a limb C P U has two values, and for one of them its two slides meet
    the three rows of a point; the limb beside it stands in two ways.
    """
    cpu = [
        Joint("c", "C", (-9, -120, 8), (-0.99, -0.05, 0.12)),
        Joint("p", "P", (-10, -90, 21), (0.14, 0.5, 0.85), actuated=True),
        Joint("u", "U", (8, -60, 110), (0.44, 0.77, 0.46), (0.54, 0.47, -0.7)),
    ]
    rps = [
        Joint("r", "R", (50, 60, 0), X),
        Joint("q", "P", (50, 60, 0), (0, 0.2, 1), actuated=True),
        Joint("s", "S", (50, 70, 100)),
    ]
    machine = Mechanism(
        "mixed", [Limb("cpu", cpu), Limb("rps", rps)], platform_position=(5, -3, 100)
    )
    found = symkin.modes(machine, pose=[5, -3, 100, 1, 0, 0, 0])
    assert len(found) == found.complex_count == 2


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_choices_that_given_values_refuse_are_not_counted(seed: int) -> None:
    """A platform that does not turn, its place by one slide in two ways, and a limb P U S whose
    driven slide refuses one of them: its joint centre is too far or too near there, or, over the
    complex numbers, at no such distance.
    """
    rng = np.random.default_rng(seed)

    def joints(spec: str) -> list[Joint]:
        found = []
        for name in spec.split():
            point, axis = rng.uniform(-100, 100, 3).round(), rng.normal(size=3).round(2)
            if name[0] == "S":
                found.append(Joint(name, "S", point))
                continue
            axes = (axis, np.cross(axis, rng.normal(size=3))) if name[0] == "U" else (axis,)
            found.append(Joint(name, name[0], point, *axes, actuated=name[0] == "P"))
        return found

    limbs = [Limb(str(k), joints(spec)) for k, spec in enumerate(["P1 R S1", "S2 S3", "P2 U S4"])]
    machine = Mechanism("prs", limbs, motion="translation", platform_position=(5, -3, 100))
    found = symkin.modes(machine, joints=[0.0, 0.0])
    assert len(found) == found.complex_count == 2
    assert found.completeness == "probability one"


def test_a_part_that_no_given_value_enters_has_its_own_redundant_rows():
    """Limbs P S under schoenflies motion: two rows tell the height, whatever the driven slide does,
    and one is redundant; the four rows of the other part are independent.
    """
    limbs = [
        Limb("a", [Joint("p1", "P", (0, 0, 0), (1, 1, 0)), Joint("s1", "S", (-40, -130, -95))]),
        Limb(
            "b",
            [
                Joint("p2", "P", (0, 0, 0), (-1, -1, 0), actuated=True),
                Joint("s2", "S", (42, 131, -95)),
            ],
        ),
    ]
    problem = build_problem(
        Mechanism("slides", limbs, platform_position=(85, 68, -180), motion="schoenflies"), "direct"
    )
    height, plane = sorted(structure_groups(problem), key=lambda part: len(part.system.unknowns))
    assert [c.name for c in height.system.unknowns] == ["pose.z"]
    assert (redundant_rows(height), redundant_rows(plane)) == (1, 0)


def test_firmware_is_refused_where_a_pose_leaves_a_limb_free(tmp_path):
    """A driven joint before a spherical one at the platform's centre of rotation is no function of
    the pose.
    """
    limbs = [
        Limb("a", [Joint("free", "R", (0, 0, 0), X, actuated=True), Joint("ball", "S", (0, 0, 0))]),
        Limb(
            "b",
            [
                Joint(f"q{k}", "R", (0, 0, 0), axis, actuated=True)
                for k, axis in enumerate((Z, X, Y))
            ],
        ),
    ]
    machine = Mechanism("loose", limbs, motion="spherical")
    from helpers.inside import Options, write_folder

    with pytest.raises(InputError, match=r"pose does not fix joints of one limb \(free\)"):
        write_folder(machine, tmp_path / "out", Options())
