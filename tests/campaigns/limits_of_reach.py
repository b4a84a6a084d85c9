"""Twelve machines at the limits of their reach: do modes appear and vanish where 50 digits say so?

Each machine has one number that is moved across a limit, where two solutions (of one block, or of
several together) meet. Its solutions are counted by its own closed form in 60 digits (circles and
spheres that meet, A cos + B sin + C = 0, roots of a polynomial), for the doubles that the file and
the input hold; the limit is found by bisection of that count. Then the input lies 1e-3 to 1e-15 (of
the size, or rad) inside and outside of it, for sizes 1e-6, 1 and 1e3, and every way of listing
modes must say the same count, unless the input is nearer to the limit than rounding (`NEAR`): there
a double mode may stand for two, or they may be there or not. Always: no more modes than complex
solutions, no residual beyond rounding, no mode twice, and a note of how much is open where there is
none.

Run: python tests/campaigns/limits_of_reach.py [--machines NAME,...] [--sizes 1e-6,1,1e3] [--ways
default,continuation,multistart]
"""

from __future__ import annotations

import argparse
import math
import re
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mpmath as mp

import symkin

mp.mp.dps = 60
OFFSETS = [10.0**-k for k in range(3, 16)]
NEAR = 40 * 2.0**-52
"""Of the size: closure error at the limit's place within which two that meet are not told apart."""
RESIDUAL = 256 * 2.0**-52
"""Of the size, or of the largest coordinate: rounding of a closed configuration."""
OPEN = re.compile(r"(open by|by up to|most is .*, by|lies) [0-9.e+-]+ (mm|m)\b")

Count = Callable[[Any], int]


@dataclass(frozen=True)
class Machine:
    """A mechanism file; what is asked for a value; solutions at a value, in 60 digits; a value
    inside and one outside; what is one unit of the offsets in the value's unit (the size, or rad in
    degrees); and by how much one unit opens the loops, over the size.
    """

    text: str
    ask: Callable[[float], dict[str, Any]]
    count: Count
    inside: float
    outside: float
    unit: float
    lever: float = 0.3


def f(x: Any) -> Any:
    """The double that the file holds, exactly."""
    return mp.mpf(float(x))


def rad(degrees: Any) -> Any:
    return mp.mpf(degrees) * mp.pi / 180


def circles(distance: Any, a: Any, b: Any) -> int:
    """Points where two circles of radii a and b meet, or two cones of half angles a and b."""
    return 2 if abs(a - b) < distance < a + b else 0


def head(name: str) -> str:
    return f'format = 1\nname = "{name}"\nlength_unit = "mm"\nangle_unit = "deg"\n'


def joint(table: str, name: str, point: Sequence[float], axis: Sequence[float], **more: Any) -> str:
    lines = [
        f"[[{table}]]",
        f'name = "{name}"',
        f"point = {[float(v) for v in point]}",
        f"axis = {[float(v) for v in axis]}",
    ]
    lines += [f'type = "{more.pop("type", "R")}"']
    lines += [
        f"{k} = {str(v).lower() if isinstance(v, bool) else _toml(v)}" for k, v in more.items()
    ]
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    return '["' + '", "'.join(value) + '"]' if isinstance(value, tuple) else repr(value)


Z, Y, X = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)


# --- planar graphs --------------------------------------------------------------------------------


def four_bar(s: float) -> Machine:
    """Crank 40, coupler 101, rocker 61 on a base of 110, the rocker given: formulas."""
    a, c, g = (40 * s, 60 * s), (99 * s, 60 * s), 110 * s
    text = head("four_bar") + joint(
        "joint", "crank", (0, 0, 0), Z, links=("base", "l1"), actuated=True
    )
    text += joint("joint", "pin", (0, a[0], 0), Z, links=("l1", "l2"))
    text += joint("joint", "pin2", (*c, 0), Z, links=("l2", "l3")) + joint(
        "joint", "follower", (g, 0, 0), Z, links=("base", "l3")
    )

    def count(value: Any) -> int:
        arm = mp.mpc(f(c[0]) - f(g), f(c[1])) * mp.expj(rad(value))
        return circles(abs(f(g) + arm), f(a[0]), mp.hypot(f(c[0]), f(c[1]) - f(a[0])))

    return Machine(text, lambda v: {"given": {"follower": v}}, count, 30.0, 60.0, 180 / math.pi)


def slider_crank(s: float) -> Machine:
    """The slide given: its crank and rod stretch to 30 + 70."""
    r, x = 30 * s, 50 * s
    text = head("slider") + joint(
        "joint", "crank", (0, 0, 0), Z, links=("base", "l1"), actuated=True
    )
    text += joint("joint", "pin", (0, r, 0), Z, links=("l1", "l2")) + joint(
        "joint", "pin2", (x, 0, 0), Z, links=("l2", "l3")
    )
    text += joint("joint", "slide", (x, 0, 0), X, type="P", links=("base", "l3"))

    def count(value: Any) -> int:
        return circles(abs(f(x) + value), f(r), mp.hypot(f(x), f(r)))

    far = r + math.hypot(x, r) - x
    return Machine(
        text,
        lambda v: {"given": {"slide": v}},
        count,
        far - 0.1 * s,
        far + 0.1 * s,
        math.hypot(x, r),
    )


def six_bar(s: float) -> Machine:
    """A four-bar whose rocker drives a second dyad, which reaches one of the rocker's two positions
    only: 4 modes or 2.
    """
    b, c, d = (0, 40 * s), (99 * s, 60 * s), 110 * s
    e, k, g = (120 * s, 75 * s), (190 * s, 40 * s), (220 * s, 0)
    text = head("six_bar") + joint(
        "joint", "crank", (0, 0, 0), Z, links=("base", "l1"), actuated=True
    )
    text += joint("joint", "pb", (*b, 0), Z, links=("l1", "l2")) + joint(
        "joint", "pc", (*c, 0), Z, links=("l2", "l3")
    )
    text += joint("joint", "pd", (d, 0, 0), Z, links=("base", "l3")) + joint(
        "joint", "pe", (*e, 0), Z, links=("l3", "l4")
    )
    text += joint("joint", "pk", (*k, 0), Z, links=("l4", "l5")) + joint(
        "joint", "pg", (*g, 0), Z, links=("base", "l5")
    )
    B, C, E, K, G = (mp.mpc(f(p[0]), f(p[1])) for p in (b, c, e, k, g))
    D = mp.mpc(f(d), 0)

    def count(value: Any) -> int:
        pin = B * mp.expj(rad(value))
        r1, r2, far = abs(C - B), abs(C - D), abs(D - pin)
        if not circles(far, r1, r2):
            return 0
        along = (far**2 + r1**2 - r2**2) / (2 * far)
        up = mp.sqrt(r1**2 - along**2)
        found = [pin + (D - pin) / far * mp.mpc(along, sign * up) for sign in (1, -1)]
        ends = [D + (E - D) / (C - D) * (p - D) for p in found]
        return sum(circles(abs(end - G), abs(K - E), abs(K - G)) for end in ends)

    return Machine(
        text,
        lambda v: {"given": {"crank": v}},
        count,
        *bracket(count, -180.0, 180.0),
        180 / math.pi,
    )


def bracket(count: Count, low: float, high: float, steps: int = 97) -> tuple[float, float]:
    """Two neighbours on a grid between which the count falls, or rises, the first with more."""
    grid = [low + (high - low) * k / steps for k in range(steps + 1)]
    counts = [count(mp.mpf(v)) for v in grid]
    places = [k for k in range(steps) if counts[k] != counts[k + 1]]
    k = places[0]
    return (grid[k], grid[k + 1]) if counts[k] > counts[k + 1] else (grid[k + 1], grid[k])


# --- spatial graphs -------------------------------------------------------------------------------


def spherical_four_bar(s: float) -> Machine:
    """Four axes through one point: two cones about the axes of input and output, or none. The input
    is given.
    """
    axes = [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.48, 0.64, 0.6), (0.0, 0.8, 0.6)]
    text = head("spherical") + "".join(
        joint("joint", n, [s * v for v in p], p, links=ends, **more)
        for n, p, ends, more in zip(
            ("j1", "j2", "j3", "j4"),
            axes,
            (("base", "a"), ("a", "b"), ("b", "c"), ("base", "c")),
            ({"actuated": True}, {}, {}, {}),
            strict=True,
        )
    )
    _, two, three, four = ([f(v) / mp.sqrt(sum(f(w) ** 2 for w in p)) for v in p] for p in axes)

    def count(value: Any) -> int:
        c, n = mp.cos(rad(value)), mp.sin(rad(value))
        turned = [c * two[0] - n * two[1], n * two[0] + c * two[1], two[2]]
        angle = mp.acos(sum(a * b for a, b in zip(turned, four, strict=True)))
        coupler, output = (
            mp.acos(sum(a * b for a, b in zip(three, other, strict=True))) for other in (two, four)
        )
        return circles(angle, coupler, output) if angle + coupler + output < 2 * mp.pi else 0

    return Machine(
        text, lambda v: {"given": {"j1": v}}, count, *bracket(count, -180.0, 180.0), 180 / math.pi
    )


def rssr(s: float) -> Machine:
    """Two cranks about skew axes with a rod between: A cos + B sin + C = 0 for the output."""
    a, b, o = (40 * s, 0.0, 10 * s), (130 * s, 60 * s, 20 * s), (130 * s, 10 * s, 0.0)
    text = head("rssr") + joint("joint", "input", (0, 0, 0), Z, links=("base", "l1"), actuated=True)
    text += joint("joint", "output", o, X, links=("base", "l2"))
    text += (
        f'[[rod]]\nname = "rod"\nlinks = ["l1", "l2"]\nfrom = {list(a)}\nto = {list(b)}\n'
        f"length = {120.0 * s}\n"
    )

    def count(value: Any) -> int:
        c, n = mp.cos(rad(value)), mp.sin(rad(value))
        p = [c * f(a[0]) - n * f(a[1]), n * f(a[0]) + c * f(a[1]), f(a[2])]
        y, z = f(b[1]) - f(o[1]), f(b[2]) - f(o[2])
        w = [f(b[0]) - p[0], f(o[1]) - p[1], f(o[2]) - p[2]]
        # |w + (0, y c - z n, y n + z c)| = length
        even, odd = 2 * (w[1] * y + w[2] * z), 2 * (w[2] * y - w[1] * z)
        rest = sum(v * v for v in w) + y * y + z * z - f(120.0 * s) ** 2
        return 2 if even**2 + odd**2 > rest**2 else 0

    return Machine(
        text,
        lambda v: {"given": {"input": v}},
        count,
        *bracket(count, -180.0, 180.0),
        180 / math.pi,
    )


# --- platforms ------------------------------------------------------------------------------------


def tripod(s: float) -> Machine:
    """Three rods to one point, lengths given: three spheres, which meet in its plane at the
    limit.
    """
    feet = [(0.0, -100 * s, 0.0), (90 * s, 50 * s, 0.0), (-80 * s, 60 * s, 0.0)]
    text = (
        head("tripod") + f'[platform]\nposition = [0.0, 0.0, {100 * s}]\nmotion = "translation"\n'
    )
    text += "".join(
        f'[[limb]]\nname = "leg{k}"\ntype = "SPS"\nbase = {list(p)}\nplatform = [0.0, 0.0, 0.0]\n'
        for k, p in enumerate(feet)
    )
    held = [101.0 * s, 97.0 * s]

    def count(value: Any) -> int:
        return 2 if _height(feet, [value, *map(f, held)]) > 0 else 0

    return Machine(
        text, lambda v: {"joints": [v, *held]}, count, *bracket(count, 60 * s, 140 * s), 170 * s
    )


def _height(feet: Sequence[Sequence[float]], radii: Sequence[Any]) -> Any:
    """Square of the height, above the plane of three centres, of the points where their spheres
    meet.
    """
    a, b, c = ([f(v) for v in p] for p in feet)
    rows, right = [], []
    for p, r in ((b, radii[1]), (c, radii[2])):
        rows.append([2 * (p[i] - a[i]) for i in range(3)])
        right.append(radii[0] ** 2 - r**2 + sum(v * v for v in p) - sum(v * v for v in a))
    u, w = rows
    normal = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]]
    at = mp.lu_solve(
        mp.matrix([u, w, normal]),
        mp.matrix([*right, sum(n * v for n, v in zip(normal, a, strict=True))]),
    )
    return radii[0] ** 2 - sum((at[i] - a[i]) ** 2 for i in range(3))


def _delta_text(s: float, rod: float) -> tuple[str, list[tuple[float, float]]]:
    """Three arms of 112 on a circle of 132, pairs of rods to a circle of 33.2; directions of the
    arms as doubles of unit length.
    """
    directions = [(1.0, 0.0), (-0.5, math.sqrt(0.75)), (-0.5, -math.sqrt(0.75))]
    text = (
        head("delta3")
        + f'[platform]\nposition = [0.0, 0.0, {-100.0 * s}]\nmotion = "translation"\n'
    )
    for k, (c, n) in enumerate(directions):
        text += f'[[limb]]\nname = "limb{k}"\n'
        text += joint(
            "limb.joint", f"motor{k}", (132 * s * c, 132 * s * n, 0), (-n, c, 0.0), actuated=True
        )
        for side in (-20 * s, 20 * s):
            start = [244 * s * c - side * n, 244 * s * n + side * c, 0.0]
            end = [33.2 * s * c - side * n, 33.2 * s * n + side * c, 0.0]
            text += f"[[limb.rod]]\nfrom = {start}\nplatform = {end}\nlength = {rod * s}\n"
    return text, directions


def delta_pose(s: float) -> Machine:
    """A delta's pose off its axis: one arm reaches its limit, the others have two elbows each."""
    text, directions = _delta_text(s, 232.0)
    x, y = -30.0 * s, 12.0 * s

    def count(value: Any) -> int:
        found = 1
        for c, n in directions:
            out, aside = (f(x) * f(c) + f(y) * f(n), f(y) * f(c) - f(x) * f(n))
            across = mp.sqrt(f(232.0 * s) ** 2 - aside**2)
            found *= circles(
                mp.hypot(f(132.0 * s) - f(33.2 * s) - out, value), f(112.0 * s), across
            )
        return found

    return Machine(
        text, lambda v: {"pose": [x, y, v, 1.0, 0.0, 0.0, 0.0]}, count, -250 * s, -340 * s, 400 * s
    )


def delta_joints(s: float) -> Machine:
    """A delta's platform for three motors: two poses, or none where the short rods do not meet."""
    text, directions = _delta_text(s, 170.0)
    held = [35.0, 47.0]

    def count(value: Any) -> int:
        centres = []
        for (c, n), angle in zip(directions, [value, *held], strict=True):
            out = f(132.0 * s) - f(33.2 * s) + f(112.0 * s) * mp.cos(rad(angle))
            centres.append((out * f(c), out * f(n), -f(112.0 * s) * mp.sin(rad(angle))))
        return 2 if _height_mp(centres, f(170.0 * s)) > 0 else 0

    return Machine(
        text,
        lambda v: {"joints": [v, *held]},
        count,
        *bracket(count, -60.0, 80.0),
        180 / math.pi,
        0.06,
    )


def _height_mp(centres: Sequence[Sequence[Any]], radius: Any) -> Any:
    """As `_height`, of spheres of one radius about centres in 60 digits: its square less that of
    their circle.
    """
    a, b, c = (mp.matrix(list(p)) for p in centres)
    sides = [mp.norm(b - c), mp.norm(c - a), mp.norm(a - b)]
    half = sum(sides) / 2
    area = mp.sqrt(half * (half - sides[0]) * (half - sides[1]) * (half - sides[2]))
    return radius**2 - (sides[0] * sides[1] * sides[2] / (4 * area)) ** 2


def three_rrr(s: float) -> Machine:
    """A planar 3-RRR's pose: one limb reaches its limit, the others have two elbows each."""
    base, tips = (
        [(0, 0), (200 * s, 0), (90 * s, 180 * s)],
        [(-30 * s, -20 * s), (30 * s, -20 * s), (0, 40 * s)],
    )
    at = (95 * s, 60 * s)
    text = head("rrr") + f'[platform]\nposition = [{at[0]}, {at[1]}, 0.0]\nmotion = "planar"\n'
    lengths = []
    for k, (b, t) in enumerate(zip(base, tips, strict=True)):
        end = (at[0] + t[0], at[1] + t[1])
        knee = ((b[0] + end[0]) / 2 + 40 * s, (b[1] + end[1]) / 2 - 50 * s)
        lengths.append(
            (
                mp.hypot(f(knee[0]) - f(b[0]), f(knee[1]) - f(b[1])),
                mp.hypot(f(end[0]) - f(knee[0]), f(end[1]) - f(knee[1])),
            )
        )
        text += f'[[limb]]\nname = "limb{k}"\n' + joint(
            "limb.joint", f"m{k}", (*b, 0), Z, actuated=True
        )
        text += joint("limb.joint", f"e{k}", (*knee, 0), Z) + joint(
            "limb.joint", f"t{k}", (*end, 0), Z
        )

    def count(value: Any) -> int:
        found = 1
        for k, (b, t) in enumerate(zip(base, tips, strict=True)):
            # the tip in the platform's frame is what is left of its place, in doubles
            own = [f(at[i] + t[i]) - f(at[i]) for i in (0, 1)]
            place = (value + own[0] - f(b[0]), f(at[1]) + own[1] - f(b[1]))
            found *= circles(mp.hypot(*place), *lengths[k])
        return found

    return Machine(
        text,
        lambda v: {"pose": [v, at[1], 0.0, 1.0, 0.0, 0.0, 0.0]},
        count,
        *bracket(count, 95 * s, 295 * s),
        270 * s,
    )


def three_rpr(s: float) -> Machine:
    """A planar 3-RPR's lengths: the real roots of a polynomial of degree 6 in exp(i phi)."""
    base, tips = (
        [(0.0, 0.0), (160 * s, 10 * s), (70 * s, 130 * s)],
        [(0.0, 0.0), (60 * s, 5 * s), (25 * s, 45 * s)],
    )
    text = head("rpr") + f'[platform]\nposition = [{60 * s}, {40 * s}, 0.0]\nmotion = "planar"\n'
    text += "".join(
        f'[[limb]]\nname = "leg{k}"\ntype = "SPS"\nbase = [{b[0]}, {b[1]}, 0.0]\n'
        f"platform = [{t[0]}, {t[1]}, 0.0]\n"
        for k, (b, t) in enumerate(zip(base, tips, strict=True))
    )
    held = [85.0 * s, 92.0 * s]
    bases, ends = ([mp.mpc(f(p[0]), f(p[1])) for p in points] for points in (base, tips))

    def gap(phi: Any, lengths: Sequence[Any]) -> Any:
        """D^2 (|p|^2 - ...) of the first leg, p from the differences of the legs' equations, which
        are linear in it.
        """
        turned = [mp.expj(phi) * t - b for t, b in zip(ends, bases, strict=True)]
        rows = [2 * (turned[k] - turned[0]) for k in (1, 2)]
        right = [
            lengths[k] ** 2 - lengths[0] ** 2 - abs(turned[k]) ** 2 + abs(turned[0]) ** 2
            for k in (1, 2)
        ]
        det = rows[0].real * rows[1].imag - rows[0].imag * rows[1].real
        px = right[0] * rows[1].imag - right[1] * rows[0].imag
        py = rows[0].real * right[1] - rows[1].real * right[0]
        return (
            (px + det * turned[0].real) ** 2
            + (py + det * turned[0].imag) ** 2
            - (det * lengths[0]) ** 2
        )

    def count(value: Any) -> int:
        unit = f(s)
        lengths, n = [value, *map(f, held)], 17
        values = [gap(2 * mp.pi * k / n, lengths) / unit**6 for k in range(n)]
        fourier = [
            sum(v * mp.expj(-2 * mp.pi * k * m / n) for k, v in enumerate(values)) / n
            for m in range(-3, 4)
        ]
        roots = mp.polyroots(fourier[::-1], maxsteps=400, extraprec=400)
        return sum(1 for z in roots if abs(abs(z) - 1) < mp.mpf(10) ** -25)

    return Machine(
        text, lambda v: {"joints": [v, *held]}, count, *bracket(count, 20 * s, 220 * s, 40), 180 * s
    )


# --- arms -----------------------------------------------------------------------------------------


def arm_of_six(s: float) -> Machine:
    """Shoulder, elbow and a spherical wrist: 8 solutions within reach of the wrist's centre, none
    beyond.
    """
    h, a, b, t = 100 * s, 150 * s, 130 * s, 40 * s
    places = [
        ((0, 0, 0), Z),
        ((0, 0, h), Y),
        ((a, 0, h), Y),
        ((a + b, 0, h), X),
        ((a + b, 0, h), Y),
        ((a + b, 0, h), X),
    ]
    text = head("arm6") + f"[tool]\nposition = [{a + b + t}, 0.0, {h}]\n"
    text += "".join(joint("joint", f"q{k + 1}", p, axis) for k, (p, axis) in enumerate(places))
    y, z = 70 * s, 160 * s

    def count(value: Any) -> int:
        # the tool points along y: the half turns of (1, 1, 1, 1) / 2 take x to y
        wrist = (value, f(y) - (f(a + b + t) - f(a + b)), f(z) - f(h))
        return 4 * circles(mp.sqrt(sum(v * v for v in wrist)), f(a), f(a + b) - f(a))

    return Machine(
        text, lambda v: {"pose": [v, y, z, 0.5, 0.5, 0.5, 0.5]}, count, 200 * s, 320 * s, 300 * s
    )


def scara(s: float) -> Machine:
    """Two links, a quill and a turn of it: two elbows."""
    a, b, z = 125 * s, 100 * s, -30 * s
    text = (
        head("scara4")
        + f"[tool]\nposition = [{a + b}, 0.0, 0.0]\n"
        + joint("joint", "q1", (0, 0, 0), Z)
    )
    text += (
        joint("joint", "q2", (a, 0, 0), Z)
        + joint("joint", "q3", (a + b, 0, 0), Z, type="P")
        + joint("joint", "q4", (a + b, 0, 0), Z)
    )
    y = 90 * s

    def count(value: Any) -> int:
        return circles(mp.hypot(value, f(y)), f(a), f(a + b) - f(a))

    return Machine(
        text, lambda v: {"pose": [v, y, z, 1.0, 0.0, 0.0, 0.0]}, count, 150 * s, 230 * s, 225 * s
    )


MACHINES = {
    m.__name__: m
    for m in (
        four_bar,
        slider_crank,
        six_bar,
        spherical_four_bar,
        rssr,
        tripod,
        delta_pose,
        delta_joints,
        three_rrr,
        three_rpr,
        arm_of_six,
        scara,
    )
}


# --- the campaign ---------------------------------------------------------------------------------


def limit(machine: Machine) -> Any:
    """The value at which the count changes, to 45 digits of what the bracket spans."""
    more, low, high = (
        machine.count(mp.mpf(machine.inside)),
        mp.mpf(machine.inside),
        mp.mpf(machine.outside),
    )
    for _ in range(150):
        middle = (low + high) / 2
        low, high = (middle, high) if machine.count(middle) == more else (low, middle)
    return (low + high) / 2


def faults(machine: Machine, found: symkin.Modes, value: float, at: Any) -> list[str]:
    """What is wrong with the modes found at a value; `at` is the limit."""
    wrong, size = [], found.problem.closure.characteristic_length
    expected, near = (
        machine.count(mp.mpf(value)),
        abs(mp.mpf(value) - at) * machine.lever < NEAR * machine.unit,
    )
    inside, doubles = (
        machine.count(mp.mpf(machine.inside)),
        [m for m in found if any("double" in n for n in m.notes)],
    )
    if not near and (len(found) != expected or doubles):
        wrong.append(f"{len(found)} modes, {len(doubles)} of them double, for {expected}")
    outside = machine.count(mp.mpf(machine.outside))
    if near and not (
        len(found) in (inside, outside) or (outside < len(found) < inside and doubles)
    ):
        wrong.append(
            f"{len(found)} modes, {len(doubles)} of them double, where {inside} become {outside}"
        )
    if found.complex_count is not None and len(found) > found.complex_count:
        wrong.append(f"{len(found)} modes of {found.complex_count} complex solutions")
    far = max(size, found.problem.mechanism.farthest)
    wrong += [
        f"residual {m.residual / far:.1e}" for m in found if not m.residual <= RESIDUAL * far
    ][:1]
    if not len(found) and not any(OPEN.search(note) for note in found.notes):
        wrong.append(f"no note says how far: {found.notes}")
    if any(m.certified is None for m in found) and found.completeness != "sampled":
        wrong.append("certified is null")
    return wrong


def run(name: str, size: float, ways: Sequence[str], folder: Path) -> tuple[int, int]:
    """Answers asked for and wrong ones, which are printed."""
    machine = MACHINES[name](size)
    path = folder / f"{name}.toml"
    path.write_text(machine.text)
    mechanism, at = symkin.load(str(path)), limit(machine)
    asked = wrong = 0
    outwards = 1 if machine.outside > machine.inside else -1
    for offset in OFFSETS:
        for side in (1, -1):
            value = float(at + side * outwards * offset * mp.mpf(machine.unit))
            for way in ways:
                method: dict[str, Any] = {} if way == "default" else {"method": way}
                asked += 1
                try:
                    told = faults(
                        machine, symkin.modes(mechanism, **machine.ask(value), **method), value, at
                    )
                except Exception as error:
                    told = [f"{type(error).__name__}: {error}"]
                wrong += bool(told)
                for text in told:
                    print(
                        f"{name} {size:g}, {offset:.0e} {'outside' if side > 0 else 'inside'}, "
                        f"{way}: {text}",
                        flush=True,
                    )
    return asked, wrong


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--machines", default=",".join(MACHINES))
    parser.add_argument("--sizes", default="1e-6,1,1e3")
    parser.add_argument("--ways", default="default,continuation,multistart")
    chosen = parser.parse_args(arguments)
    asked = wrong = 0
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        for name in chosen.machines.split(","):
            for size in chosen.sizes.split(","):
                more = run(name, float(size), chosen.ways.split(","), Path(folder))
                asked, wrong = asked + more[0], wrong + more[1]
            print(
                f"{name}: {asked} asked, {wrong} wrong, {time.perf_counter() - begin:.0f} s",
                flush=True,
            )
    print(f"{asked} answers, {wrong} wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
