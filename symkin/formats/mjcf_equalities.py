"""Equality constraints of MJCF: which are active, what they join, which joints they hold, and their
frames.

What they mean is MuJoCo's documentation, "XML reference: equality", and `mj_instantiateEqual` of
its source.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symkin.errors import MechanismError, SymkinError
from symkin.formats.mjcf_model import CompiledModel
from symkin.formats.xml_text import Element, read_xml
from symkin.spatial.pose import Pose

_READ = ("connect", "weld", "joint", "tendon")
_DEEPEST = 20
"""Files that include each other."""


@dataclass(frozen=True)
class Equality:
    """An active equality constraint: its type's name, its number in the model, its two objects (-1:
    none), and its place.
    """

    kind: str
    number: int
    objects: tuple[int, int]
    where: str


def active_equalities(compiled: CompiledModel, notes: list[str]) -> list[Equality]:
    """The constraints that are active, but those that hang on mocap bodies; `notes` tell what is
    left out. Raises MechanismError for those that are no kinematics of links.
    """
    model, found = compiled.model, []
    written = list(_written(compiled.root, compiled.path))
    tags = list(compiled.kinds["equality"])
    for k, kind in enumerate(tags):
        where = _place(compiled, written, tags, k)
        equality = Equality(kind, k, (int(model.eq_obj1id[k]), int(model.eq_obj2id[k])), where)
        if not model.eq_active0[k]:
            notes.append(f"{where}: it is not active, and left out")
        elif kind not in _READ:
            raise MechanismError(
                f"{where}: {kind} constraints are not kinematics of links; take it out, or make it "
                f"inactive"
            )
        elif kind in ("connect", "weld") and any(
            model.body_mocapid[body_of(compiled, equality, end)] >= 0 for end in (0, 1)
        ):
            notes.append(
                f"{where}: it joins a mocap body, which is moved from outside, and is left out"
            )
        else:
            found.append(equality)
    return found


def _place(compiled: CompiledModel, written: list[Element], tags: list[str], number: int) -> str:
    """Where a constraint stands in the file: of multiplied elements, and those that the compiler
    makes of others, that is not known.
    """
    kind = tags[number]
    same = [element for element in written if element.tag == kind]
    if len(same) == tags.count(kind):
        return same[tags[:number].count(kind)].where
    name = (
        compiled.names["flex"][int(compiled.model.eq_obj1id[number])]
        if kind.startswith("flex")
        else ""
    )
    maker = next(
        (
            e
            for e in compiled.root.walk()
            if name and e.tag.startswith("flex") and e.attributes.get("name") == name
        ),
        None,
    )
    return (
        f"{compiled.path}: <{kind}> number {number + 1} of the equality constraints"
        if maker is None
        else maker.where
    )


def held_values(
    compiled: CompiledModel, equalities: list[Equality], notes: list[str]
) -> dict[int, float]:
    """Joints that an equality holds at a value."""
    found: dict[int, float] = {}
    for equality in equalities:
        joint, other = equality.objects
        if equality.kind == "joint" and other < 0:
            value = compiled.at_qpos0(joint) + float(compiled.model.eq_data[equality.number][0])
            name = compiled.joint_name(joint)
            if found.get(joint, value) != value:
                raise MechanismError(f"{equality.where}: the joint {name!r} is held at two values")
            found[joint] = value
            notes.append(
                f"the joint {name!r} is held at {value:g} by an equality: its link is part of the "
                f"one that carries it"
            )
    return found


def body_of(compiled: CompiledModel, equality: Equality, end: int) -> int:
    """The body at one end of a connect or weld."""
    number = equality.objects[end]
    return (
        int(compiled.model.site_bodyid[number])
        if compiled.by_sites[equality.number]
        else max(number, 0)
    )


def is_rigid(compiled: CompiledModel, equality: Equality) -> bool:
    """Whether a constraint holds directions as well as a point."""
    return equality.kind == "weld" and float(compiled.model.eq_data[equality.number][10]) != 0.0


def frames_on_bodies(compiled: CompiledModel, equality: Equality) -> tuple[Pose, Pose]:
    """The frames of a connect or weld in those of its two bodies."""
    numbers = compiled.model.eq_data[equality.number]
    if compiled.by_sites[equality.number]:
        return compiled.site_pose(equality.objects[0]), compiled.site_pose(equality.objects[1])
    if equality.kind == "connect":
        return _at(numbers[0:3]), _at(numbers[3:6])
    turn = numbers[6:10] / np.linalg.norm(numbers[6:10])
    return Pose(numbers[3:6].copy(), turn), _at(numbers[0:3])


def _at(point: np.ndarray) -> Pose:
    return Pose(point.copy(), np.array([1.0, 0.0, 0.0, 0.0]))


def _written(element: Element, file: Path, depth: int = 0) -> Iterator[Element]:
    """The elements of all <equality>, those of included files too, in the order in which the
    compiler meets them.
    """
    for child in element.children:
        if child.tag == "equality":
            yield from (
                e for part in child.children for e in _included(part, file, depth, inside=True)
            )
        elif child.tag == "include":
            yield from _included(child, file, depth, inside=False)


def _included(element: Element, file: Path, depth: int, *, inside: bool) -> Iterator[Element]:
    """An element itself, or for an include what stands in its file; nothing where that cannot be
    read here.
    """
    if element.tag != "include":
        yield element
        return
    path = file.parent / element.attributes.get("file", "")
    try:
        root = read_xml(path)
    except SymkinError:
        return
    if depth < _DEEPEST:
        yield from (
            (e for part in root.children for e in _included(part, file, depth + 1, inside=True))
            if inside
            else _written(root, file, depth + 1)
        )
