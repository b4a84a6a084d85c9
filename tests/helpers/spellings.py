"""One machine written in many ways: limbs or a graph, another format, unit, order, reference, place
or size; and its modes as places of its links, in which all of them can be compared.

Lengths, poses and displacements of a spelling are turned back into those of the first spelling of
its machine, the home.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

import symkin
from helpers import moved_points, samples
from helpers.graph_twin import graph_twin
from helpers.inside import (
    POSE_CONDITIONS,
    build_closure,
    displaced,
    scaled,
    tilt_and_torsion,
    with_reference_at,
)
from helpers.moved_mechanisms import (
    as_revolutes,
    in_length_unit,
    reordered,
    revolute_links,
    with_axes_reversed,
    with_point,
)
from symkin import Joint, Limb, Mechanism, Modes, Pose, Rod, RodLimb, Solution

HOME = Pose.from_euler([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
TURN = Pose.from_euler([0.0, 0.0, 0.0], [0.3, 0.5, 0.7])
ABOUT_Z = Pose.from_euler([0.0, 0.0, 0.0], [0.0, 0.0, 0.7])
TURNED_ABOUT_Z = ("planar", "schoenflies")
"""Motions that a machine keeps only when it is turned about the base frame's z axis."""
SAME = 1e-5
"""Largest difference of places of links, over the size, and of their directions, of one mode."""
ANGLE, LENGTH = 0.07, 0.013
"""Steps off the reference, in radians and in sizes: inputs are about their first multiples."""


@dataclass(frozen=True)
class Machine:
    """A machine as `home` describes it. `forced`: its joints leave the platform the declared motion
    and no other in any configuration, so that declaring it changes no mode. `seed` is of the input.
    """

    name: str
    home: Mechanism
    forced: bool = True
    seed: int = 0

    @cached_property
    def values(self) -> dict[str, float]:
        """Values of the actuated joints beside the reference, in radians and home's unit."""
        steps = {True: ANGLE, False: LENGTH * self.home.characteristic_length}
        rng = np.random.default_rng(self.seed)
        return {
            c.name: c.reference[0] + (k + rng.uniform(-0.4, 0.4)) * steps[c.is_angular]
            for k, c in enumerate(self.home.actuated, start=1)
        }

    @cached_property
    def configuration(self) -> Solution:
        """The configuration of these values that belongs to the reference."""
        joints = {c.name: self.values[c.name] for c in self.home.actuated}
        found = symkin.solve(self.home, joints=_in_units(self.home, joints, 1.0)).solution
        assert found is not None
        return found


@dataclass(frozen=True)
class Spelling:
    """A machine as `mechanism` describes it: turned by `turn`, its lengths `factor` times those of
    the home, from a reference at which links stand `moved`; `links` are names of its own for links
    of the home. Spellings of one `kind` have the same modes.
    """

    name: str
    mechanism: Mechanism
    kind: str = ""
    factor: float = 1.0
    turn: Pose = HOME
    moved: Mapping[str, Pose] = field(default_factory=dict)
    links: Mapping[str, str] = field(default_factory=dict)

    @property
    def is_turned(self) -> bool:
        """Whether it stands otherwise than the home."""
        return self.turn is not HOME

    def told(self, pose: Pose) -> Pose:
        """A pose of the home as this spelling has it."""
        turned = self.turn @ pose
        return Pose(self.factor * np.array(turned.position), turned.quaternion)

    def taken(self, pose: Pose) -> Pose:
        """A pose of this spelling as the home has it."""
        return self.turn.inverse() @ Pose(np.array(pose.position) / self.factor, pose.quaternion)

    def modes(
        self, machine: Machine, *, inverse: bool, method: str | None = None, off: float = 0.0
    ) -> Modes:
        """The modes at the machine's input, its pose moved `off` sizes along the home's z axis."""
        if not inverse:
            joints = _in_units(self.mechanism, machine.values, self.factor)
            return symkin.modes(self.mechanism, joints=joints, method=method)
        at, away = machine.configuration.pose, off * machine.home.characteristic_length
        there = self.told(Pose(at.position + [0.0, 0.0, away], at.quaternion))
        return symkin.modes(self.mechanism, pose=there, method=method)

    def by_name(self, machine: Machine, names: Sequence[str]) -> tuple[Modes, Solution]:
        """The modes at values by name, those of one of the modes at the machine's input, and that
        mode. Parts of a pose are those of the spelling's own frame.
        """
        one = self.modes(machine, inverse=False)[0]
        angles = map(self.mechanism.angle_out, tilt_and_torsion(one.quaternion))
        pose = dict(zip(POSE_CONDITIONS, (*map(float, one.position), *angles), strict=True))
        values = {name: one.joints.get(name, pose.get(name)) for name in names}
        return symkin.modes(self.mechanism, given=values), one  # type: ignore[arg-type]

    def configurations(self, machine: Machine, found: Modes) -> dict[str, np.ndarray]:
        """Where each link is in each mode (modes, 12) as the home has it: the place of its point
        that is the origin at the home's reference, over the size, and its rotation.
        """
        size = machine.home.characteristic_length
        rows: dict[str, list[np.ndarray]] = {}
        names = {own: name for name, own in self.links.items()}
        for mode in found:
            for own, pose in mode.link_poses.items():
                name = names.get(own, own)
                if own not in names and name in self.links:
                    continue  # a link between two revolutes, with the name of another at home
                at = self.taken(pose) @ self.turn @ self.moved.get(name, HOME)
                row = np.concatenate([np.ravel(at.position) / size, np.ravel(at.rotation)])
                rows.setdefault(name, []).append(row)
        return {name: np.array(table) for name, table in rows.items()}


def _in_units(m: Mechanism, values: Mapping[str, float], factor: float) -> dict[str, float]:
    """Values of joints, in radians and the home's length, in a mechanism's own units."""
    return {
        c.name: m.angle_out(values[c.name]) if c.is_angular else factor * values[c.name]
        for c in m.actuated
    }


def lacking(
    some: Mapping[str, np.ndarray], others: Mapping[str, np.ndarray], counts: tuple[int, int]
) -> list[int]:
    """Places of modes among `some` that are not among `others`, by the links that both have."""
    if not counts[0] or not counts[1]:
        return list(range(counts[0]))
    names = sorted(set(some) & set(others))
    ours, theirs = (np.concatenate([one[name] for name in names], axis=1) for one in (some, others))
    return [k for k, row in enumerate(ours) if np.min(np.max(np.abs(theirs - row), axis=1)) > SAME]


# --- spellings ------------------------------------------------------------------------------------


def spellings(machine: Machine, folder: Path) -> Iterator[Spelling]:
    """All spellings of a machine; files of other formats are written to a folder."""
    home = machine.home
    plain = replace(home, motion="spatial")
    kinds = ("declared", "free") if home.motion != "spatial" and not machine.forced else ("", "")
    if home.motion != "spatial":
        yield Spelling("limbs, motion", home, kinds[0])
        yield Spelling("graph, motion", graph_twin(home), kinds[0])
    if home.dh is not None:
        yield Spelling("DH", home)
    limbs = replace(plain, dh=None)
    yield Spelling("joints" if home.serial else "limbs", limbs, kinds[1])
    yield Spelling("graph", graph_twin(limbs), kinds[1])
    for name, form in (("limbs", home), ("graph", graph_twin(home))):
        yield from _of_form(name, machine, form, kinds[0])
    if home.motion in TURNED_ABOUT_Z:
        yield Spelling("limbs, turned", displaced(plain, TURN), kinds[1], turn=TURN)
        yield Spelling("graph, turned", displaced(graph_twin(plain), TURN), kinds[1], turn=TURN)
    if any(joint.type == "U" for _, joint in limbs.joints):
        split = Spelling("limbs, R R for U", as_revolutes(limbs), kinds[1])
        yield replace(split, links=revolute_links(limbs))
        yield Spelling("graph, R R for U", as_revolutes(graph_twin(limbs)), kinds[1])
    metres = {"m": 1.0, "mm": 1e-3}[home.length_unit]
    for name, suffix in (("MJCF", ".xml"), ("URDF", ".urdf")):
        file = symkin.convert(home, folder / f"{home.name}{suffix}")
        yield Spelling(name, symkin.load(file), kinds[0], metres)


def _of_form(name: str, machine: Machine, form: Mechanism, kind: str) -> Iterator[Spelling]:
    """What can be done to limbs as to a graph."""
    unit, factor = {"m": ("mm", 1e3), "mm": ("m", 1e-3)}[form.length_unit]
    yield Spelling(f"{name}, {unit}", in_length_unit(form, unit), kind, factor)
    if len(form.limbs) != 1:
        yield Spelling(f"{name}, reordered", reordered(form, 1), kind)
    turn = ABOUT_Z if form.motion in TURNED_ABOUT_Z else TURN
    about = " about z" if turn is ABOUT_Z else ""
    yield Spelling(f"{name}, turned{about}", displaced(form, turn), kind, turn=turn)
    yield Spelling(f"{name}, point", with_point(form), kind)
    yield Spelling(f"{name}, axes", with_axes_reversed(form), kind)
    there = machine.configuration
    if not machine.home.serial:
        moved = with_reference_at(build_closure(machine.home, there.partition), there.variables)
        moved = graph_twin(moved) if name == "graph" else moved
        yield Spelling(f"{name}, reference", moved, kind, moved=there.link_poses)
    for size in (1e-8, 1e6):
        yield Spelling(f"{name}, {size:g}", scaled(form, size), kind, size)


# --- machines -------------------------------------------------------------------------------------


def slider_crank() -> Mechanism:
    """Crank 40, connecting rod 85, piston along x; the platform is the connecting rod."""
    pin, piston = (0.0, 40.0, 0.0), (75.0, 0.0, 0.0)
    crank = Joint("crank", "R", (0.0, 0.0, 0.0), samples.Z, actuated=True, zero=math.pi / 2)
    slide = Joint("slide", "P", piston, (1.0, 0.0, 0.0), zero=75.0)
    limbs = [
        Limb("left", [crank, samples.turning("big_end", *pin[:2])]),
        Limb("right", [slide, samples.turning("small_end", *piston[:2])]),
    ]
    return Mechanism("slider_crank", limbs, platform_position=pin, motion="planar")


def three_ruu() -> Mechanism:
    """A delta by U joints: arms as those of `delta`, each with one bar between U joints whose outer
    axes are tangents.
    """
    d, limbs = samples.DELTA, []
    gap = d["base"] + d["arm"] - d["platform"]
    depth = -math.sqrt(d["rod"] ** 2 - gap**2)
    for k in range(3):
        outward, tangent = samples.delta_directions(k)
        tip = (d["base"] + d["arm"]) * outward
        end = d["platform"] * outward + np.array([0.0, 0.0, depth])
        across = tuple(np.cross(tangent, end - tip) / d["rod"])
        joints = [
            Joint(f"q{k + 1}", "R", tuple(d["base"] * outward), tuple(tangent), actuated=True),
            Joint(f"u{k + 1}", "U", tuple(tip), tuple(tangent), axis2=across),
            Joint(f"v{k + 1}", "U", tuple(end), across, axis2=tuple(tangent)),
        ]
        limbs.append(Limb(f"limb{k + 1}", joints))
    return Mechanism("three_ruu", limbs, platform_position=(0, 0, depth), motion="translation")


def agile_eye() -> Mechanism:
    """A spherical 3-RRR whose arcs are all of 90 degrees, its axes along x, y, z at the
    reference.
    """
    axes, limbs = np.eye(3), []
    for k in range(3):
        first, last, middle = axes[k], axes[(k + 1) % 3], axes[(k + 2) % 3]
        names = (f"motor{k + 1}", f"elbow{k + 1}", f"tip{k + 1}")
        joints = [
            Joint(name, "R", tuple(100 * axis), tuple(axis), actuated=name.startswith("motor"))
            for name, axis in zip(names, (first, middle, last), strict=True)
        ]
        limbs.append(Limb(f"limb{k + 1}", joints))
    return Mechanism("agile_eye", limbs, motion="spherical")


def ankle() -> Mechanism:
    """A foot on a U joint, pitch then roll, and two cranks with rods: the dimensions of the shipped
    one.
    """
    limbs: list[Limb | RodLimb] = [
        Limb("shank", [Joint("ankle", "U", (0, 0, 0), (0, 1, 0), axis2=(1, 0, 0))])
    ]
    for name, side, height in (("upper", 1, 250.0), ("lower", -1, 180.0)):
        motor = Joint(f"{name}_motor", "R", (0, 40 * side, height), (0, 1, 0), actuated=True)
        rod = Rod((-45, 40 * side, height + 5.0), (-50, 35 * side, 80.0))
        limbs.append(Limb(name, [motor], [rod]))
    return Mechanism("ankle", limbs, platform_position=(0.0, 0.0, -60.0))


def six_ups() -> Mechanism:
    """Six rods between random points."""
    rng = np.random.default_rng(3)
    legs = [RodLimb(f"leg{i}", samples.unit(rng), samples.unit(rng)) for i in range(6)]
    return Mechanism("six_ups", legs, platform_position=(0.1, 0.2, 1.5), length_unit="m")


MACHINES = {
    "five-bar": lambda: Machine("five-bar", samples.readme_five_bar("planar")),
    "3-RRR": lambda: Machine("3-RRR", samples.three_rrr("planar")),
    "3-RPR": lambda: Machine("3-RPR", moved_points.three_rpr()),
    "slider-crank": lambda: Machine("slider-crank", slider_crank()),
    "delta": lambda: Machine("delta", samples.delta(), forced=False),
    "3-RUU": lambda: Machine("3-RUU", three_ruu(), forced=False),
    "3-RPS": lambda: Machine("3-RPS", samples.three_rps()),
    "Agile Eye": lambda: Machine("Agile Eye", agile_eye()),
    "Tricept": lambda: Machine("Tricept", moved_points.tricept()),
    "6-UPS": lambda: Machine("6-UPS", six_ups()),
    "6-RUS": lambda: Machine("6-RUS", samples.rus(6)),
    "ankle": lambda: Machine("ankle", ankle()),
    "UR arm": lambda: Machine("UR arm", replace(symkin.load("ur5e"), example=None)),
}
"""Makers of the machines by name."""


def named(spelled: Sequence[Spelling], names: Sequence[str]) -> list[Spelling]:
    """Those spellings of these names, all where no name is told."""
    return [one for one in spelled if not names or one.name in names]
