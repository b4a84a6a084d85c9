"""Equality constraints of MJCF: which are active, where they stand, and which joints they hold.

What they mean is MuJoCo's documentation, "XML reference: equality", and `mj_instantiateEqual` of
its source.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from symkin.errors import MechanismError, SymkinError
from symkin.formats.mjcf_model import CompiledModel, Record
from symkin.formats.xml_text import Element, read_xml

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
