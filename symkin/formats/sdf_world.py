"""Choose what of an SDF file is the robot: its one model, that which is named, or the models of a
world that joints join.
"""

from __future__ import annotations

from collections.abc import Sequence

from symkin.errors import InputError
from symkin.formats.sdf_frames import WORLD, is_static
from symkin.formats.xml_text import Element
from symkin.text import first_of, meant, shown


def robot_model(root: Element, named: str | None, notes: list[str]) -> Element:
    """The model to read; `named` is the one that is asked for, `notes` tell what of a world is left
    out.

    A world whose models are joined by its own joints is one model, its models being nested ones.
    Raises MechanismError where it is open which model is meant, InputError for a name that none
    has.
    """
    worlds = root.all("world")
    candidates = [e for part in (root, *worlds) for e in part.all("model", "include")]
    if named is not None:
        chosen = next((e for e in candidates if _name(e) == named), None)
        if chosen is None:
            names = [_name(e) for e in candidates]
            raise InputError(
                f"model: {root.file} has no model {shown(named)}{meant(named, names)}; its models: "
                f"{first_of(names, 20) or 'none'}"
            )
        return _alone(chosen, worlds, notes)
    joined = next((world for world in worlds if world.all("joint")), None)
    if joined is not None:
        return _whole(joined)
    models = [e for e in candidates if e.tag == "model"]
    moving = (
        [e for e in models if any(part.tag in ("joint", "include") for part in e.walk())]
        or models
        or candidates
    )
    if len(moving) != 1:
        names = [_name(e) for e in moving]
        remedy = (
            f": {first_of(names)}; name one of them by model (--model {names[0]})"
            if names
            else "; one is needed"
        )
        raise root.error(f"{len(moving)} models are found{remedy}")
    return _alone(moving[0], worlds, notes)


def _alone(model: Element, worlds: Sequence[Element], notes: list[str]) -> Element:
    """One model, without what stands beside it in a world."""
    if is_static(model):
        raise model.needed("static").error("the model is static: no joint of it moves")
    for world in worlds:
        for other in world.all("include", "joint"):
            if other is not model:
                notes.append(
                    f"line {other.line}: <{other.tag}> of the world is left out; the model is read "
                    f"alone"
                )
    return model if model.tag == "model" else _wrapped(model, [model], name=_name(model))


def _whole(world: Element) -> Element:
    """All models of a world as one, whose own frames are attached to the world."""
    parts = world.all("model", "include", "joint", "frame")
    return _wrapped(world, parts, name=world.attributes.get("name", WORLD), canonical_link=WORLD)


def _wrapped(place: Element, children: list[Element], **attributes: str) -> Element:
    """A model that the file does not write, at the place of an element that it does."""
    return Element("model", attributes, place.file, place.line, children)


def _name(element: Element) -> str:
    """A model's name, and that of an include: its own or the last part of its address."""
    if element.tag == "model":
        return element.attributes.get("name", "")
    address = element.child_text("uri").rstrip("/")
    return element.child_text("name", address.rpartition("/")[2])
