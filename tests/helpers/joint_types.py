"""Every joint type and motion of the mechanism format, a mechanism each."""

from __future__ import annotations

import math

import numpy as np

from symkin import Joint, Limb, Mechanism, Rod, RodLimb

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def _around(
    radius: float, height: float, turn: float = 0.0, count: int = 3
) -> list[tuple[float, float, float]]:
    angles = [turn + 2 * math.pi * k / count for k in range(count)]
    return [
        (round(radius * math.cos(a), 9), round(radius * math.sin(a), 9), height) for a in angles
    ]


def _tangent(k: int) -> tuple[float, float, float]:
    return _around(1.0, 0.0, math.pi / 2)[k]


def helical_actuated() -> Mechanism:
    """3-HRS: vertical screws, tilting links, ball joints."""
    limbs = []
    for k, (base, elbow, end) in enumerate(
        zip(_around(100, 0), _around(100, 40), _around(60, 110, 0.3), strict=True)
    ):
        limbs.append(
            Limb(
                f"limb{k + 1}",
                [
                    Joint(f"h{k + 1}", "H", base, Z, pitch=30.0, actuated=True),
                    Joint(f"r{k + 1}", "R", elbow, _tangent(k)),
                    Joint(f"s{k + 1}", "S", end),
                ],
            )
        )
    return Mechanism("helical_actuated", limbs, platform_position=(0.0, 0.0, 110.0))


def helical_passive() -> Mechanism:
    """One screw beside a slider: the slider's travel turns the platform on its screw."""
    limbs = [
        Limb("screw", [Joint("h", "H", (0, 0, 0), Z, pitch=20.0)]),
        Limb(
            "slider", [Joint("p", "P", (50, 0, 0), Z, actuated=True), Joint("c", "R", (0, 0, 0), Z)]
        ),
    ]
    return Mechanism("helical_passive", limbs, platform_position=(10.0, 0.0, 30.0))


def cylindrical() -> Mechanism:
    """RCCC: the spatial four-bar of one revolute and three cylindrical joints."""
    left = [
        Joint("q", "R", (0, 0, 0), Z, actuated=True),
        Joint("c1", "C", (60, 0, 10), (0.3, 0.2, 1.0)),
    ]
    right = [
        Joint("c2", "C", (150, 20, 0), (-0.4, 0.3, 1.0)),
        Joint("c3", "C", (140, 110, 20), (0.2, -0.5, 1.0)),
    ]
    return Mechanism(
        "cylindrical",
        [Limb("left", left), Limb("right", right)],
        platform_position=(90.0, 70.0, 10.0),
    )


def cylindrical_universal() -> Mechanism:
    """3-PCU: actuated sliders, cylindrical and universal joints."""
    limbs = []
    for k, (base, mid, end) in enumerate(
        zip(_around(90, 0), _around(100, 50), _around(60, 100, 0.4), strict=True)
    ):
        limbs.append(
            Limb(
                f"limb{k + 1}",
                [
                    Joint(f"p{k + 1}", "P", base, Z, actuated=True),
                    Joint(f"c{k + 1}", "C", mid, _tangent(k)),
                    Joint(f"u{k + 1}", "U", end, _around(1.0, 0.0)[k], Z),
                ],
            )
        )
    return Mechanism("cylindrical_universal", limbs, platform_position=(0.0, 0.0, 100.0))


def universal() -> Mechanism:
    """6-UPS with its universal and ball joints written out."""
    limbs = []
    base, end = _around(100, 0, 0.15, 6), _around(60, 120, 0.6, 6)
    base = [b if k % 2 else _around(100, 0, -0.35, 6)[k] for k, b in enumerate(base)]
    for k, (b, e) in enumerate(zip(base, end, strict=True)):
        axis = tuple((np.array(e) - b).tolist())
        limbs.append(
            Limb(
                f"limb{k + 1}",
                [
                    Joint(f"u{k + 1}", "U", b, X, Y),
                    Joint(f"p{k + 1}", "P", b, axis, actuated=True),
                    Joint(f"s{k + 1}", "S", e),
                ],
            )
        )
    return Mechanism("universal", limbs, platform_position=(0.0, 0.0, 120.0))


def rods_at_the_end() -> Mechanism:
    """6-RSS: six cranks, each with one rod."""
    limbs = []
    for k in range(6):
        a = 2 * math.pi * k / 6 + (0.15 if k % 2 else -0.15)
        pivot = (100 * math.cos(a), 100 * math.sin(a), 0.0)
        out = (math.cos(a), math.sin(a), 0.0)
        tip = tuple(pivot[i] + 40 * out[i] for i in range(3))
        b = 2 * math.pi * k / 6 + (-0.3 if k % 2 else 0.3)
        end = (60 * math.cos(b), 60 * math.sin(b), 0.0)
        tangent = (-math.sin(a), math.cos(a), 0.0)
        limbs.append(
            Limb(
                f"limb{k + 1}",
                [Joint(f"q{k + 1}", "R", pivot, tangent, actuated=True)],
                [Rod(tip, end)],
            )
        )
    return Mechanism("rods_at_the_end", limbs, platform_position=(0.0, 0.0, 120.0))


def spherical() -> Mechanism:
    """Three rods turn a platform about a fixed ball."""
    base, end = _around(100, -80), _around(60, 20, 0.7)
    rods = [RodLimb(f"leg{k + 1}", b, e) for k, (b, e) in enumerate(zip(base, end, strict=True))]
    return Mechanism("spherical", rods, motion="spherical")


def ball() -> Mechanism:
    """The same with the ball written out as a limb, free in space."""
    base, end = _around(100, -80), _around(60, 20, 0.7)
    rods = [RodLimb(f"leg{k + 1}", b, e) for k, (b, e) in enumerate(zip(base, end, strict=True))]
    return Mechanism("ball", [*rods, Limb("post", [Joint("s", "S", (0, 0, 0))])])


def planar_rods() -> Mechanism:
    """3-RPR by rods, planar."""
    rods = [
        RodLimb(f"leg{k + 1}", b, e)
        for k, (b, e) in enumerate(zip(_around(100, 0), _around(30, 0, 0.5), strict=True))
    ]
    return Mechanism("planar_rods", rods, motion="planar")


def schoenflies() -> Mechanism:
    """Four rods move a platform that only turns about z."""
    base = [(120.0, 0.0, 0.0), (0.0, 130.0, 20.0), (-110.0, 10.0, 0.0), (10.0, -125.0, -20.0)]
    end = [(30.0, 25.0, 0.0), (-25.0, 30.0, 0.0), (-30.0, -25.0, 10.0), (25.0, -30.0, 0.0)]
    rods = [RodLimb(f"leg{k + 1}", b, e) for k, (b, e) in enumerate(zip(base, end, strict=True))]
    return Mechanism("schoenflies", rods, platform_position=(0.0, 0.0, 150.0), motion="schoenflies")


def translation() -> Mechanism:
    """Linear delta: three vertical sliders with pairs of rods."""
    limbs = []
    for k in range(3):
        out, tangent = np.array(_around(1.0, 0.0)[k]), np.array(_tangent(k))
        tip, end = 120 * out + [0, 0, 150], 40 * out
        rods = [Rod(tuple(tip + s * 25 * tangent), tuple(end + s * 25 * tangent)) for s in (-1, 1)]
        limbs.append(
            Limb(f"limb{k + 1}", [Joint(f"p{k + 1}", "P", tuple(tip), Z, actuated=True)], rods)
        )
    return Mechanism("translation", limbs, motion="translation")


def _arm(
    name: str,
    spec: list[tuple[tuple[float, ...], tuple[float, ...]]],
    tool: tuple[float, float, float],
) -> Mechanism:
    joints = [Joint(f"q{k}", "R", p, a, actuated=True) for k, (p, a) in enumerate(spec, start=1)]
    return Mechanism(name, [Limb(name, joints)], serial=True, platform_position=tool)


def five_joints() -> Mechanism:
    spec = [((0, 0, 0), Z), ((0, 0, 80), Y), ((0, 0, 180), Y), ((90, 0, 180), Y), ((90, 0, 180), X)]
    return _arm("five_joints", spec, (120.0, 0.0, 180.0))


def mixed_arm() -> Mechanism:
    """A serial arm with a slider and a screw."""
    joints = [
        Joint("q1", "R", (0, 0, 0), Z, actuated=True),
        Joint("p2", "P", (0, 0, 0), Z, actuated=True),
        Joint("p3", "P", (0, 0, 80), X, actuated=True),
        Joint("h4", "H", (60, 0, 80), Z, pitch=10.0, actuated=True),
        Joint("q5", "R", (80, 0, 80), Y, actuated=True),
        Joint("q6", "R", (80, 0, 60), X, actuated=True),
    ]
    return Mechanism(
        "mixed_arm", [Limb("arm", joints)], serial=True, platform_position=(110.0, 10.0, 60.0)
    )


def seven_joints() -> Mechanism:
    """A redundant arm of the usual seven: shoulder, elbow and wrist of alternating axes."""
    spec = [
        ((0, 0, 0), Z),
        ((0, 0, 90), Y),
        ((0, 0, 180), Z),
        ((20, 0, 270), Y),
        ((0, 0, 360), Z),
        ((0, 0, 430), Y),
        ((15, 0, 430), Z),
    ]
    return _arm("seven_joints", spec, (15.0, 0.0, 480.0))


def eight_joints() -> Mechanism:
    """Seven revolute joints on a rail."""
    spec = [
        ((0, 0, 0), Z),
        ((0, 0, 90), Y),
        ((0, 0, 180), Z),
        ((20, 0, 270), Y),
        ((0, 0, 360), Z),
        ((0, 0, 430), Y),
        ((15, 0, 430), Z),
    ]
    joints = [Joint(f"q{k}", "R", p, a, actuated=True) for k, (p, a) in enumerate(spec, start=1)]
    rail = Joint("rail", "P", (0, 0, 0), X, actuated=True, limits=(-500.0, 500.0))
    return Mechanism(
        "eight_joints",
        [Limb("arm", [rail, *joints])],
        serial=True,
        platform_position=(15.0, 0.0, 480.0),
    )


MADE = [
    helical_actuated,
    helical_passive,
    cylindrical,
    cylindrical_universal,
    universal,
    rods_at_the_end,
    spherical,
    ball,
    planar_rods,
    schoenflies,
    translation,
    five_joints,
    mixed_arm,
    seven_joints,
    eight_joints,
]
