"""Random graphs of links that are closed at their reference: any joints, rods and couplings, names
and units.
"""

from __future__ import annotations

import numpy as np

import symkin
from helpers.inside import JOINT_FORMS
from helpers.samples import point, unit

_NAMES = ["knee", "q 1", "a'b", 'hip"2"', "toe#3", "Gelenk ä", "x/y", "1st", "l-r", "rod*"]


def random_graph(seed: int, *, lines_only: bool = False) -> symkin.Mechanism:
    """Three to six links with one to three loops; joints of all types, welds that close loops,
    rods, couplings (of one other joint, as lines, where `lines_only`).
    """
    rng = np.random.default_rng(seed)
    size = 100.0 if seed % 2 else 0.4
    links = ["base", *(f"link {k}" for k in range(1, int(rng.integers(3, 7))))]
    pairs = [(links[int(rng.integers(k))], links[k]) for k in range(1, len(links))]
    loops = [
        tuple(links[int(i)] for i in rng.choice(len(links), 2, replace=False))
        for _ in range(int(rng.integers(1, 4)))
    ]
    names = [f"{_NAMES[k % len(_NAMES)]}{k}" for k in range(len(pairs) + len(loops))]
    joints = []
    for k, (name, pair) in enumerate(zip(names, [*pairs, *loops], strict=True)):
        pair = pair if rng.random() < 0.5 else pair[::-1]
        kind = "weld" if k >= len(pairs) and rng.random() < 0.1 else str(rng.choice(list("RPHCUS")))
        joints.append(symkin.LinkJoint(_joint(rng, kind, name, size), pair))
    rods = [_rod(rng, f"strut{k}", links, size) for k in range(int(rng.integers(0, 3)))]
    plain = symkin.Mechanism(
        f"random_{seed}",
        link_joints=joints,
        link_rods=rods,
        length_unit="mm" if seed % 2 else "m",
        angle_unit="deg",
    )
    return symkin.Mechanism(
        plain.name,
        link_joints=joints,
        link_rods=rods,
        couplings=_couplings(rng, plain, lines_only=lines_only),
        length_unit=plain.length_unit,
        angle_unit="deg",
    )


def _joint(rng: np.random.Generator, kind: str, name: str, size: float) -> symkin.Joint:
    at = point(rng, size)
    if kind in ("S", "weld"):
        return symkin.Joint(name, kind, at)
    actuated = bool(rng.random() < 0.3)
    if JOINT_FORMS[kind].freedom != 1:
        axis, axis2 = unit(rng), unit(rng) if kind == "U" else None
        if axis2 is not None and rng.random() < 0.5:
            axis2 = np.cross(axis, axis2)  # square, as formats have it that know universal joints
        return symkin.Joint(name, kind, at, axis, axis2, actuated=actuated)
    scale = size if kind == "P" else 2.0 * np.pi
    limits = sorted(scale * rng.uniform(-1, 1, 2)) if rng.random() < 0.4 else None
    pitch = size * float(rng.uniform(0.1, 0.5)) if kind == "H" else 0.0
    zero = scale * float(rng.uniform(-1, 1)) if rng.random() < 0.6 else 0.0
    return symkin.Joint(
        name, kind, at, unit(rng), pitch=pitch, actuated=actuated, zero=zero, limits=limits
    )


def _rod(rng: np.random.Generator, name: str, links: list[str], size: float) -> symkin.LinkRod:
    pair = [links[int(i)] for i in rng.choice(len(links), 2, replace=False)]
    start, end = point(rng, size), point(rng, size)
    if rng.random() < 0.5:
        length = float(np.linalg.norm(np.subtract(end, start))) if rng.random() < 0.5 else None
        return symkin.LinkRod(name, pair, start, end, length=length)
    limits = [-size, size] if rng.random() < 0.5 else None
    return symkin.LinkRod(
        name, pair, start, end, actuated=True, offset=size * float(rng.random()), limits=limits
    )


def _couplings(
    rng: np.random.Generator, plain: symkin.Mechanism, *, lines_only: bool
) -> list[symkin.Coupling]:
    """Each holds at the reference; each follows coordinates that come before it."""
    scalars = [
        c for c in plain.coordinates if c.kind != "quaternion" and c.name.partition("strut")[0]
    ]
    found = []
    for k in range(1, len(scalars)):
        if rng.random() < 0.8:
            continue
        own, others = (
            scalars[k],
            [scalars[int(i)] for i in rng.choice(k, min(k, 1 if lines_only else 2), replace=False)],
        )
        if not lines_only and rng.random() < 0.3:
            powers = (
                rng.uniform(-1, 1, int(rng.integers(3, 6)))
                / max(1.0, abs(others[0].reference[0])) ** 2
            )
            rest = sum(c * others[0].reference[0] ** j for j, c in enumerate(powers) if j)
            powers[0] = own.reference[0] - rest
            found.append(symkin.Coupling(own.name, others[0].name, polynomial=powers.tolist()))
            continue
        factors = {c.name: float(rng.uniform(-2, 2)) for c in others}
        offset = own.reference[0] - sum(factors[c.name] * c.reference[0] for c in others)
        found.append(symkin.Coupling(own.name, factors, offset))
    return found
