"""The model that MuJoCo compiled of a file, as records by their numbers in it: where its parts
stand in the file, which equality constraints are active, which joints these hold, and which joints
follow or drive each other.

What constraints mean is MuJoCo's documentation, "XML reference: equality", and
`mj_instantiateEqual` of its source.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from symkin.errors import MechanismError, SymkinError
from symkin.formats.couplings import CouplingSet, LinearEquation
from symkin.formats.packages import Packages
from symkin.formats.robot import Mesh
from symkin.formats.xml_text import Element, read_xml
from symkin.model.graph import Coupling
from symkin.model.motor import Motor, motor_of
from symkin.spatial.pose import Pose
from symkin.text import counted, first_of

_NO_NAME = "MuJoCo Model"
"""What the compiler calls a model without a name."""
_RECORDS = ("bodies", "joints", "equalities", "tendons", "actuators", "meshes", "shown")
Record = Any
"""A body, joint, equality, tendon or actuator as `formats/mujoco_worker.py` tells it."""
CompiledModel = Any
"""All that `formats/mujoco_worker.py` tells of a model, by its keys: lists of records, `qpos`,
`idle`, `finite`, `texts`, `name`; with the file's `root` element and `path`.
"""


def compiled_model(told: Mapping[str, Any], root: Element, path: Path) -> CompiledModel:
    """The model of a worker's answer."""
    records = {key: [SimpleNamespace(**entry) for entry in told[key]] for key in _RECORDS}
    name = None if told["name"] == _NO_NAME else told["name"]
    return SimpleNamespace(**{**told, **records, "name": name}, root=root, path=path)


def meshes_of(compiled: CompiledModel) -> list[tuple[int, Mesh]]:
    """The meshes that geoms show, by the numbers of their bodies, in whose frames they stand:
    refpos and refquat move them before their scale. Raises MechanismError for a scale of 0.
    """
    packages, found = Packages(compiled.path), {}
    for mesh in compiled.meshes:
        x, y, z = scale = np.array(mesh.scale)
        if not np.all(np.isfinite(scale)) or 0.0 in scale:
            raise _written(compiled.root, mesh).error(
                f"scale = {scale.tolist()} makes nothing of the mesh; numbers other than 0 are "
                f"needed"
            )
        turn = np.array(mesh.refquat)
        back = Pose(np.zeros(3), turn / np.linalg.norm(turn)).inverse()
        at = Pose(-scale * back.turn(np.array(mesh.refpos)), back.quaternion)
        found[mesh.name] = packages.written(mesh.file), at, (float(x), float(y), float(z))
    shown = ((g, *found[g.mesh]) for g in compiled.shown)
    return [
        (g.body, Mesh(file, pose_of(g.position, g.quaternion) @ at, scale))
        for g, file, at, scale in shown
    ]


def _written(root: Element, mesh: Record) -> Element:
    """The element of a mesh that tells its scale, as far as it can be told from others."""
    elements = [e for e in root.walk() if e.tag == "mesh" and "scale" in e.attributes]
    named = (e for e in elements if mesh.named and mesh.name == e.attributes.get("name"))
    return next(named, elements[0] if elements else root)


def pose_of(position: Sequence[float], quaternion: Sequence[float]) -> Pose:
    """A pose of a record's numbers."""
    return Pose(np.array(position), np.array(quaternion))


_READ = ("connect", "weld", "joint", "tendon")
_DEEPEST = 20
"""Files that include each other."""


def active_equalities(compiled: CompiledModel, notes: list[str]) -> list[Record]:
    """The constraints that are active, but those that hang on mocap bodies, with their places in
    the file (`where`); `notes` tell what is left out. Raises MechanismError for those that are no
    kinematics of links.
    """
    found = []
    sections = [e for e in _parts(compiled.root, compiled.path) if e.tag == "equality"]
    written = [e for section in sections for e in _parts(section, compiled.path)]
    tags = [told.kind for told in compiled.equalities]
    for k, told in enumerate(compiled.equalities):
        where = told.where = _place(compiled, written, tags, k)
        if not told.active:
            notes.append(f"{where}: it is not active, and left out")
        elif told.kind not in _READ:
            raise MechanismError(
                f"{where}: {told.kind} constraints are not kinematics of links; take it out, or "
                f"make it inactive"
            )
        elif told.closes and any(compiled.bodies[body].mocap for body in told.bodies):
            notes.append(
                f"{where}: it joins a mocap body, which is moved from outside, and is left out"
            )
        else:
            found.append(told)
    return found


def _place(compiled: CompiledModel, written: list[Element], tags: list[str], number: int) -> str:
    """Where a constraint stands in the file: of multiplied elements, and those that the compiler
    makes of others, that is not known.
    """
    kind = tags[number]
    same = [element for element in written if element.tag == kind]
    if len(same) == tags.count(kind):
        return same[tags[:number].count(kind)].where
    name = compiled.equalities[number].flex
    makers = (
        e.where
        for e in compiled.root.walk()
        if name and e.tag.startswith("flex") and e.attributes.get("name") == name
    )
    unknown = f"{compiled.path}: <{kind}> number {number + 1} of the equality constraints"
    return next(makers, unknown)


def held_values(
    compiled: CompiledModel, equalities: list[Record], notes: list[str]
) -> dict[int, float]:
    """Joints that an equality holds at a value."""
    found: dict[int, float] = {}
    for equality in equalities:
        joint, other = equality.objects
        if equality.kind == "joint" and other < 0:
            value = compiled.joints[joint].zero + equality.coefficients[0]
            name = compiled.joints[joint].name
            if found.get(joint, value) != value:
                raise MechanismError(f"{equality.where}: the joint {name!r} is held at two values")
            found[joint] = value
            notes.append(
                f"the joint {name!r} is held at {value:g} by an equality: its link is part of the "
                f"one that carries it"
            )
    return found


def _parts(element: Element, file: Path, depth: int = 0) -> Iterator[Element]:
    """What stands within an element, in the order in which the compiler meets it: in the place of
    an include what its file holds, nothing where that cannot be read here.
    """
    for child in element.children:
        if child.tag != "include":
            yield child
            continue
        try:
            root = read_xml(file.parent / child.attributes.get("file", ""))
        except SymkinError:
            continue
        if depth < _DEEPEST:
            yield from _parts(root, file, depth + 1)


Terms = list[tuple[int, float]]
"""Joints by number, and the factor of each."""


def couplings_of(
    compiled: CompiledModel,
    equalities: list[Record],
    held: Mapping[int, float],
    names: Mapping[int, str],
) -> CouplingSet:
    """The couplings of joint and tendon equalities, first - first0 = c0 + c1 d + c2 d^2 + ..., d =
    second - second0, both from qpos0, of joints or sums of them; `held` joints stand at a value,
    and are no part of them.
    """
    found = CouplingSet()
    for equality in equalities:
        holds = equality.kind == "joint" and equality.objects[1] < 0
        if holds or equality.kind not in ("joint", "tendon"):
            continue
        first, second = (_terms(compiled, equality, number) for number in equality.objects)
        start, other = (
            sum(f * compiled.joints[j].zero for j, f in terms) for terms in (first, second)
        )
        coefficients = list(equality.coefficients)
        while len(coefficients) > 2 and coefficients[-1] == 0.0:
            coefficients.pop()
        if len(coefficients) > 2:
            if not len(first) == len(second) == 1 or {first[0][0], second[0][0]} & held.keys():
                raise MechanismError(
                    f"{equality.where}: a polynomial of more than one joint, or of a held one, is "
                    f"not read; write it linearly"
                )
            (joint, own), (of, factor) = first[0], second[0]
            inner = np.polynomial.Polynomial([-other, factor])
            polynomial = (np.polynomial.Polynomial(coefficients)(inner) + start) / own
            powers = [float(c) for c in polynomial.coef]
            found.add(Coupling(names[joint], names[of], polynomial=powers), equality.where)
            continue
        slope = coefficients[1] if second else 0.0
        constant, terms = coefficients[0] + start - slope * other, dict[str, float]()
        for j, factor in [*first, *((j, -slope * f) for j, f in second)]:
            if j in held:
                constant -= factor * held[j]
            else:
                terms[names[j]] = terms.get(names[j], 0.0) + factor
        if any(terms.values()):
            found.add_linear(LinearEquation(terms, constant, equality.where))
    return found


def _terms(compiled: CompiledModel, equality: Record, number: int) -> Terms:
    """A joint, or the joints and factors of a fixed tendon; none where there is no second."""
    if number < 0:
        return []
    if equality.kind == "joint":
        return [(number, 1.0)]
    tendon = compiled.tendons[number]
    if tendon.joints is None:
        raise MechanismError(
            f"{equality.where}: its tendon {tendon.name!r} is a spatial one; only fixed tendons "
            f"are read"
        )
    return list(map(tuple, tendon.joints))


def motor_at(compiled: CompiledModel, joint: int) -> Motor | None:
    """What the file tells of the motors at a hinge or slide: the armature of the joint and of its
    actuators; the forces of these, as far as each has a range, and as far as the joint takes them.
    """
    own = [a for a in compiled.actuators if a.direct and joint in a.joints]
    armature = compiled.joints[joint].armature + sum(a.armature * a.gear * a.gear for a in own)
    low, high = compiled.joints[joint].force
    ranges = [sorted(a.gear * force for force in a.force) for a in own]
    if ranges:
        low = max(low, sum(first for first, _ in ranges))
        high = min(high, sum(last for _, last in ranges))
    return motor_of((low, high), None, armature)


def without_kinematics(compiled: CompiledModel) -> Iterator[str]:
    """Notes on what of the file moves no link by itself."""
    spatial = sum(tendon.joints is None for tendon in compiled.tendons)
    counts = {"spatial tendon": spatial, **compiled.idle}
    named = [counted(count, what) for what, count in counts.items() if count]
    if named:
        yield f"left out, since it moves no link by itself: {', '.join(named)}"


def idle_actuators(compiled: CompiledModel) -> Iterator[str]:
    """Notes on actuators that drive no joint, and on a file without any."""
    named = enumerate(compiled.actuators, start=1)
    idle = [a.name or f"number {k}" for k, a in named if not a.joints]
    if idle:
        yield (
            f"actuators that drive no hinge or slide, directly or by a fixed tendon, are left out: "
            f"{first_of(idle)}"
        )
    if not compiled.actuators:
        yield "the file has no actuator: no joint is actuated, and values are given by name"
