"""Random mechanisms, and small classical ones whose kinematics has a closed form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

import symkin
from helpers.documents import machines
from helpers.inside import parse
from symkin import Joint, Limb, LinkJoint, Mechanism, Rod, RodLimb

Z = (0.0, 0.0, 1.0)
seeds = st.integers(0, 2**32 - 1).map(np.random.default_rng)
"""Random generators, so that a failing example is one integer."""


def unit(rng: np.random.Generator, count: int = 3) -> tuple[float, ...]:
    v = rng.normal(size=count)
    return tuple(float(x) for x in v / np.linalg.norm(v))


def point(rng: np.random.Generator, size: float = 100.0) -> tuple[float, ...]:
    return tuple(float(x) for x in rng.uniform(-size, size, 3))


def random_joint(
    rng: np.random.Generator, kind: str, name: str, *, actuated: bool = False
) -> Joint:
    single = kind in "RPH"
    return Joint(
        name,
        kind,  # type: ignore[arg-type]
        point(rng),
        axis=None if kind == "S" else unit(rng),
        axis2=unit(rng) if kind == "U" else None,
        pitch=float(rng.uniform(-50, 50)) if kind == "H" else 0.0,
        actuated=actuated,
        zero=float(rng.uniform(-3, 3)) if single else 0.0,
    )


def random_limb(rng: np.random.Generator, kinds: str, name: str) -> Limb:
    """A limb by its joint letters; a lower-case letter is an actuated joint: 'rRS'."""
    joints = [
        random_joint(rng, k.upper(), f"{name}j{i}", actuated=k.islower())
        for i, k in enumerate(kinds)
    ]
    return Limb(name, joints)


def random_mechanism(rng: np.random.Generator, limbs: Sequence[str], **options: Any) -> Mechanism:
    """Limbs by their letters; 'SPS' (upper case, exactly that) is a rod limb."""
    made: list[Limb | RodLimb] = []
    for k, kinds in enumerate(limbs):
        name = f"limb{k}"
        made.append(
            RodLimb(name, point(rng), point(rng))
            if kinds == "SPS"
            else random_limb(rng, kinds, name)
        )
    options = {"platform_position": point(rng), "platform_quaternion": unit(rng, 4)} | options
    return Mechanism("sample", made, **options)


def random_coordinate(rng: np.random.Generator, coordinate: Any) -> Any:
    if coordinate.kind == "quaternion":
        return unit(rng, 4)
    return float(rng.uniform(-3, 3)) if coordinate.is_angular else float(rng.uniform(-100, 100))


def turning(name: str, x: float, y: float, *, actuated: bool = False) -> Joint:
    """A revolute joint about the vertical through (x, y)."""
    return Joint(name, "R", (x, y, 0.0), Z, actuated=actuated)


# --- classical mechanisms -------------------------------------------------------------------------


def four_bar() -> tuple[Mechanism, tuple[float, float, float, float]]:
    """Ground 100, crank 40, coupler 90, rocker 70, all spatial; the crank's coordinate is its angle
    from +x. The platform frame stands in the joint of crank and coupler, x along the coupler at the
    reference.
    """
    ground, crank, coupler, rocker = 100.0, 40.0, 90.0, 70.0
    begin = math.radians(60)
    b = np.array([crank * math.cos(begin), crank * math.sin(begin)])
    c = circles(b, coupler, np.array([ground, 0.0]), rocker)[0]
    slope = math.atan2(c[1] - b[1], c[0] - b[0])
    driver = Joint("crank", "R", (0.0, 0.0, 0.0), Z, actuated=True, zero=begin)
    limbs = [
        Limb("left", [driver, turning("b", b[0], b[1])]),
        Limb("right", [turning("d", ground, 0.0), turning("c", c[0], c[1])]),
    ]
    half = 0.5 * slope
    pose = {
        "platform_position": (b[0], b[1], 0.0),
        "platform_quaternion": (math.cos(half), 0.0, 0.0, math.sin(half)),
    }
    return Mechanism("four_bar", limbs, **pose), (ground, crank, coupler, rocker)


def circles(a: np.ndarray, r: float, b: np.ndarray, s: float) -> list[np.ndarray]:
    """The two points at distance r from a and s from b, the one to the left of a -> b first; none
    when they miss.
    """
    d = b - a
    length = float(np.linalg.norm(d))
    along = (length**2 + r**2 - s**2) / (2 * length)
    if r**2 < along**2:
        return []
    across = math.sqrt(r**2 - along**2) * np.array([-d[1], d[0]]) / length
    return [a + along * d / length + across, a + along * d / length - across]


def five_bar() -> Mechanism:
    """Bases (0, 0) and (100, 0), cranks 60 to (0, 60) and (100, 60), couplers 80 to P; the platform
    is the left coupler, its frame in P with the base's directions. The cranks' coordinates are
    their angles from +x.
    """
    p = circles(np.array([0.0, 60.0]), 80.0, np.array([100.0, 60.0]), 80.0)[0]
    left = Joint("q1", "R", (0.0, 0.0, 0.0), Z, actuated=True, zero=math.pi / 2)
    right = Joint("q2", "R", (100.0, 0.0, 0.0), Z, actuated=True, zero=math.pi / 2)
    limbs = [
        Limb("left", [left, turning("b1", 0.0, 60.0)]),
        Limb("right", [right, turning("b2", 100.0, 60.0), turning("p", p[0], p[1])]),
    ]
    return Mechanism("five_bar", limbs, platform_position=(p[0], p[1], 0.0), angle_unit="deg")


RRR_BASE, RRR_PLATFORM, RRR_LINKS = 100.0, 30.0, (60.0, 65.0)


def readme_five_bar(motion: str = "spatial") -> Mechanism:
    """The tutorial's: bases 150 apart, cranks 100 that stand upright at 0, couplers 150."""
    text = machines("docs/tutorials/describe.md")["five_bar.toml"]
    return parse(text.replace('motion = "planar"', f'motion = "{motion}"'), "five_bar.toml")


def three_rrr(motion: str = "spatial") -> Mechanism:
    """Planar 3-RRR: base joints on a circle of 100, platform joints on one of 30, links 60 and 65,
    platform at rest in the middle. The actuated coordinates are the first links' angles from +x.
    """
    limbs = []
    for k in range(3):
        towards = math.pi / 2 + 2 * math.pi * k / 3
        direction = np.array([math.cos(towards), math.sin(towards)])
        base, end = RRR_BASE * direction, RRR_PLATFORM * direction
        elbow = circles(base, RRR_LINKS[0], end, RRR_LINKS[1])[0]
        zero = math.atan2(elbow[1] - base[1], elbow[0] - base[0])
        first = Joint(f"q{k + 1}", "R", (base[0], base[1], 0.0), Z, actuated=True, zero=zero)
        limbs.append(
            Limb(f"limb{k + 1}", [first, turning(f"b{k + 1}", *elbow), turning(f"c{k + 1}", *end)])
        )
    return Mechanism("three_rrr", limbs, motion=motion)  # type: ignore[arg-type]


BENNETT = """
format = 1
name = "bennett"
length_unit = "mm"
angle_unit = "deg"

# A = (p, 0, 0), C = (-p, 0, 0), B = (x, y, h), D = (-x, -y, h), a half turn about z apart,
# so that AB = CD and BC = DA;
# each axis is normal to the two links that meet there: p = 50, x = 40 cos 70, y = 40 sin 70,
# h = 30.
[platform]
position = ["40*cos(70)", "40*sin(70)", 30]

[[limb]]
name = "ab"
[[limb.joint]]
name = "A"
type = "R"
point = ["100/2", 0, 0]
axis = ["30*40*sin(70)", "-30*40*cos(70)", "50*40*sin(70)"]
actuated = true
[[limb.joint]]
name = "B"
type = "R"
point = ["40*cos(70)", "40*sin(70)", 30]
axis = [0, 30, "-40*sin(70)"]

[[limb]]
name = "dc"
[[limb.joint]]
name = "D"
type = "R"
point = ["-40*cos(70)", "-40*sin(70)", "6^2 - 6"]
axis = [0, -30, "-40*sin(70)"]
[[limb.joint]]
name = "C"
type = "R"
point = [-50, 0, 0]
axis = ["-30*40*sin(70)", "30*40*cos(70)", "50*40*sin(70)"]
"""

DELTA = {"base": 120.0, "arm": 100.0, "rod": 220.0, "platform": 40.0, "width": 25.0}


def three_rps() -> Mechanism:
    """Three limbs R P S on equilateral triangles; each R is tangential, each P leans inwards."""
    limbs = []
    for i, angle in enumerate(np.radians([0, 120, 240]), start=1):
        c, s = math.cos(angle), math.sin(angle)
        lean = np.array([-100 * c, -100 * s, 300.0])
        length = float(np.linalg.norm(lean))
        foot, ball = (200 * c, 200 * s, 0.0), (100 * c, 100 * s, 300.0)
        joints = [
            Joint(f"r{i}", "R", foot, (-s, c, 0)),
            Joint(f"p{i}", "P", foot, lean / length, actuated=True, zero=length),
        ]
        limbs.append(Limb(f"limb{i}", [*joints, Joint(f"s{i}", "S", ball)]))
    return Mechanism("three_rps", limbs, platform_position=(0, 0, 300))


def delta() -> Mechanism:
    """A delta robot by rods: arms of 100 turn about tangents of a circle of 120, and hang level and
    outward at 0; each carries a pair of rods of 220 to the platform's circle of 40; z is up,
    positive angles lower the arms.
    """
    d = DELTA
    gap = d["base"] + d["arm"] - d["platform"]
    depth = -math.sqrt(d["rod"] ** 2 - gap**2)
    limbs = []
    for k in range(3):
        outward, tangent = delta_directions(k)
        pivot, tip, end = (
            d["base"] * outward,
            (d["base"] + d["arm"]) * outward,
            d["platform"] * outward,
        )
        rods = [
            Rod(tuple(tip + s * d["width"] * tangent), tuple(end + s * d["width"] * tangent))
            for s in (-1, 1)
        ]
        limbs.append(
            Limb(
                f"limb{k + 1}",
                [Joint(f"q{k + 1}", "R", tuple(pivot), tuple(tangent), actuated=True)],
                rods,
            )
        )
    return Mechanism("delta", limbs, platform_position=(0.0, 0.0, depth), motion="translation")


def delta_directions(k: int) -> tuple[np.ndarray, np.ndarray]:
    """Outward and tangent unit vectors of limb k; the tangent turns `outward` down."""
    angle = 2 * math.pi * k / 3
    return np.array([math.cos(angle), math.sin(angle), 0.0]), np.array(
        [-math.sin(angle), math.cos(angle), 0.0]
    )


def hexapod(
    base: Sequence[Sequence[float]], platform: Sequence[Sequence[float]], height: float = 100.0
) -> Mechanism:
    limbs = [
        RodLimb(f"leg{k}", b, a)
        for k, (b, a) in enumerate(zip(base, platform, strict=True), start=1)
    ]
    return Mechanism("hexapod", limbs, platform_position=(0.0, 0.0, height))


def pieper() -> Mechanism:
    """A 6R arm whose last three axes meet: vertical waist, two parallel horizontal joints, and a
    z-y-z wrist.
    """
    y = (0.0, 1.0, 0.0)
    spec = [
        ((0, 0, 0), Z),
        ((0, 0, 80), y),
        ((0, 0, 180), y),
        ((90, 0, 180), Z),
        ((90, 0, 180), y),
        ((90, 0, 180), Z),
    ]
    joints = [Joint(f"q{k}", "R", p, a, actuated=True) for k, (p, a) in enumerate(spec, start=1)]
    return Mechanism(
        "pieper", [Limb("pieper", joints)], serial=True, platform_position=(90.0, 0.0, 220.0)
    )


def parallel_rrr(motion: str = "spatial") -> Mechanism:
    """Planar 3-RRR whose second links (40) are parallel and whose elbows make a triangle equal to
    the platform's (circle of 50): with the first links held, the platform moves on a circle.
    """
    limbs = []
    for k in range(3):
        angle = 2 * math.pi * k / 3 + 0.3
        direction = np.array([math.cos(angle), math.sin(angle)])
        base, elbow, end = 100 * direction, 50 * direction, 50 * direction + [40.0, 0.0]
        first = Joint(f"q{k + 1}", "R", (base[0], base[1], 0.0), Z, actuated=True)
        limbs.append(
            Limb(f"limb{k + 1}", [first, turning(f"b{k + 1}", *elbow), turning(f"c{k + 1}", *end)])
        )
    return Mechanism("parallel_rrr", limbs, platform_position=(40.0, 0.0, 0.0), motion=motion)  # type: ignore[arg-type]


def bars(
    ground: float, crank: float, coupler: float, rocker: float, motion: str = "planar", **options
) -> Mechanism:
    """A four-bar driven by its crank, at 60 degrees at the reference; the platform is the coupler,
    its frame in the crank's pin.
    """
    begin = math.radians(60)
    b = np.array([crank * math.cos(begin), crank * math.sin(begin)])
    c = circles(b, coupler, np.array([ground, 0.0]), rocker)[0]
    driver = Joint("crank", "R", (0.0, 0.0, 0.0), Z, actuated=True, zero=begin, **options)
    limbs = [
        Limb("left", [driver, turning("b", b[0], b[1])]),
        Limb("right", [turning("d", ground, 0.0), turning("c", c[0], c[1])]),
    ]
    return Mechanism("bars", limbs, platform_position=(b[0], b[1], 0.0), motion=motion)


def tilted_rps() -> Mechanism:
    """Three limbs R-P-S from a circle of 150 to a platform of 100 at a height of 200."""
    limbs = []
    for k in range(3):
        angle = 2 * math.pi * k / 3
        out = np.array([math.cos(angle), math.sin(angle), 0.0])
        axis = np.array([0.0, 0.0, 200.0]) - 50 * out
        joints = [
            Joint(f"r{k + 1}", "R", point=tuple(150 * out), axis=(-out[1], out[0], 0.0)),
            Joint(
                f"d{k + 1}",
                "P",
                point=tuple(150 * out),
                axis=tuple(axis / np.linalg.norm(axis)),
                actuated=True,
                zero=float(np.linalg.norm(axis)),
            ),
            Joint(f"s{k + 1}", "S", point=(100 * out[0], 100 * out[1], 200.0)),
        ]
        limbs.append(Limb(f"limb{k + 1}", joints))
    return Mechanism(name="tilted", limbs=tuple(limbs), platform_position=(0.0, 0.0, 200.0))


def tied_platform(
    elbow: bool, radii: tuple[float, float, float] = (100.0, 100.0, 100.0)
) -> Mechanism:
    """Three limbs R P S, or R R S with `elbow`, in planes through the vertical axis."""
    limbs = []
    for k, radius in enumerate(radii):
        c, s = math.cos(2 * math.pi * k / 3), math.sin(2 * math.pi * k / 3)
        foot, head, axis = (
            np.array([radius * c, radius * s, 0.0]),
            np.array([60.0 * c, 60.0 * s, 150.0]),
            (-s, c, 0.0),
        )
        along, knee = (
            (head - foot) / np.linalg.norm(head - foot),
            0.5 * (foot + head) + 40.0 * np.array([c, s, 0.0]),
        )
        first = Joint(f"r{k}", "R", tuple(foot), axis, actuated=elbow)
        second = (
            Joint(f"e{k}", "R", tuple(knee), axis)
            if elbow
            else Joint(f"p{k}", "P", tuple(foot), tuple(along), actuated=True)
        )
        limbs.append(Limb(f"limb{k}", [first, second, Joint(f"s{k}", "S", tuple(head))]))
    return Mechanism("tied", limbs, platform_position=(0.0, 0.0, 150.0), angle_unit="deg")


def planar_pose(x: float, y: float, turn: float = 0.0) -> list[float]:
    """A pose in the plane x, y, turned about z."""
    return [x, y, 0.0, math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)]


def hexagons(height: float = 120.0) -> Mechanism:
    """A regular hexagon of 120 over a semi-regular one of 200: platform joints stand 20 degrees
    before and after base joints.
    """
    base, platform = (
        np.radians([10, 110, 130, 230, 250, 350]),
        np.radians([30, 90, 150, 210, 270, 330]),
    )
    ring = [
        np.column_stack([r * np.cos(t), r * np.sin(t), np.zeros(6)])
        for r, t in ((200, base), (120, platform))
    ]
    return hexapod([tuple(b) for b in ring[0]], [tuple(a) for a in ring[1]], height)


GROUND, CRANK, COUPLER, ROCKER = 100.0, 70.0, 60.0, 50.0
TOGGLE = math.acos((GROUND**2 + CRANK**2 - (COUPLER + ROCKER) ** 2) / (2 * GROUND * CRANK))
"""The crank angle at which coupler and rocker are in line."""


def rocker_angle(angle: float, branch: int) -> float:
    """Angle of the rocker of a four-bar GROUND, CRANK, COUPLER, ROCKER, closed form."""
    b = CRANK * np.array([math.cos(angle), math.sin(angle)])
    c = circles(b, COUPLER, np.array([GROUND, 0.0]), ROCKER)[branch]
    return math.atan2(c[1], c[0] - GROUND)


def rus(limbs: int) -> Mechanism:
    """Limbs of a motor, a U joint and an S joint, in pairs: at a pose two places of the motor and
    two of the U joint for each.
    """
    made = []
    for k in range(limbs):
        side, middle = (-1, 1)[k % 2], 120.0 * (k // 2)
        base, top = (math.radians(middle + side * angle) for angle in (12.0, 45.0))
        out, across = (
            np.array([math.cos(base), math.sin(base), 0.0]),
            np.array([-math.sin(base), math.cos(base), 0.0]),
        )
        joints = [
            Joint(f"m{k}", "R", 180.0 * out, out, actuated=True),
            Joint(f"u{k}", "U", 180.0 * out - 70.0 * side * across, out, axis2=Z),
            Joint(f"s{k}", "S", (110.0 * math.cos(top), 110.0 * math.sin(top), 260.0)),
        ]
        made.append(Limb(f"limb{k}", joints))
    return Mechanism("rus", made, platform_position=(0.0, 0.0, 260.0), length_unit="mm")


def rus_on_rods(limbs: int) -> Mechanism:
    """The first limbs of six `rus`, and rods of driven length where the others' U and S joints
    are: fewer places of the same U joints at the poses of a body on six legs.
    """
    whole = rus(6)
    rods = [
        RodLimb(f"leg{k}", *(joint.point for joint in limb.joints[1:]))
        for k, limb in enumerate(whole.limbs[limbs:], start=limbs)
    ]
    return replace(whole, limbs=[*whole.limbs[:limbs], *rods])


def two_four_bars() -> Mechanism:
    """Two four-bars that share a crank and nothing else."""
    bars = symkin.load("four_bar")
    crank, pin, follower_pin, follower = bars.link_joints
    points = {"_pin": (0.0, 40.0, 0.0), "_far": (-75.0, 80.0, 0.0), "_end": (-90.0, 5.0, 0.0)}
    links = [(crank.links[1], "left"), ("left", "left_rocker"), ("base", "left_rocker")]
    second = [
        LinkJoint(Joint(f"left{name}", "R", point, Z), pair)
        for (name, point), pair in zip(points.items(), links, strict=True)
    ]
    return replace(
        bars, name="two_four_bars", link_joints=[crank, pin, follower_pin, follower, *second]
    )


def tricept_of_joints(pairs: bool) -> Mechanism:
    """Three limbs U P S about one of U P; `pairs`: each U as two revolutes."""

    def crossed(name: str, point, first, second) -> list[Joint]:
        if not pairs:
            return [Joint(name, "U", point, first, axis2=second)]
        return [Joint(f"{name}.1", "R", point, first), Joint(f"{name}.2", "R", point, second)]

    limbs = []
    for k, turn in enumerate(2 * np.pi * np.arange(3) / 3):
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        foot, head = 150 * out, 60 * out + [0, 0, 300.0]
        length = float(np.linalg.norm(head - foot))
        along = (head - foot) / length
        across = np.cross(along, Z) / np.linalg.norm(np.cross(along, Z))
        slide = Joint(f"q{k}", "P", foot, along, actuated=True, zero=length)
        first = crossed(f"u{k}", foot, across, np.cross(along, across))
        limbs.append(Limb(f"l{k}", [*first, slide, Joint(f"s{k}", "S", head)]))
    middle = crossed("c", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    limbs.append(Limb("centre", [*middle, Joint("slide", "P", (0.0, 0.0, 0.0), Z)]))
    return Mechanism("tricept", limbs, platform_position=(0.0, 0.0, 300.0))


def with_actuated(mechanism: Mechanism, names: list[str]) -> Mechanism:
    """The mechanism of links with other motors, and nothing told of where it begins."""
    joints = [
        replace(link, joint=replace(link.joint, actuated=link.joint.name in names))
        for link in mechanism.link_joints
    ]
    return replace(mechanism, link_joints=tuple(joints), example=None)


def exechon() -> symkin.Mechanism:
    """Two limbs U P R in the plane y = 0, whose first axes are one line, and one S P R
    (Exechon).
    """
    limbs = []
    for k, (foot, head) in enumerate(
        [((250.0, 0, 0), (100.0, 0, 600.0)), ((-250.0, 0, 0), (-100.0, 0, 600.0))], start=1
    ):
        along = tuple(np.subtract(head, foot) / np.linalg.norm(np.subtract(head, foot)))
        universal = symkin.Joint(f"u{k}", "U", foot, (1, 0, 0), (0, 1, 0))
        slide, hinge = (
            symkin.Joint(f"p{k}", "P", foot, along, actuated=True),
            symkin.Joint(f"r{k}", "R", head, (0, 1, 0)),
        )
        limbs.append(symkin.Limb(f"limb{k}", [universal, slide, hinge]))
    foot, head = (0.0, 300.0, 0.0), (0.0, 120.0, 600.0)
    along = tuple(np.subtract(head, foot) / np.linalg.norm(np.subtract(head, foot)))
    ball, slide = symkin.Joint("s3", "S", foot), symkin.Joint("p3", "P", foot, along, actuated=True)
    limbs.append(symkin.Limb("limb3", [ball, slide, symkin.Joint("r3", "R", head, (1, 0, 0))]))
    return symkin.Mechanism("exechon", limbs, platform_position=(0.0, 0.0, 600.0), angle_unit="deg")
