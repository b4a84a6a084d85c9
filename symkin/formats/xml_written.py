"""Write XML: elements with numbers that read back as they were, in the same order every time."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree

from symkin.errors import MechanismError
from symkin.formats.xml_text import DEEPEST

Element = ElementTree.Element


def element(tag: str, /, **attributes: object) -> Element:
    """An element; numbers and vectors are written with all their digits, attributes that are None
    are left out, and a _ behind a name that Python keeps is dropped.
    """
    found = {
        key.rstrip("_"): _text(value) for key, value in attributes.items() if value is not None
    }
    return Element(tag, found)


def inside(parent: Element, tag: str, text: object = None, /, **attributes: object) -> Element:
    """A new element at the end of another one, with a text."""
    child = element(tag, **attributes)
    if text is not None:
        child.text = _text(text)
    parent.append(child)
    return child


def document(root: Element, name: str, told: str = "") -> str:
    """The text of a mechanism's file, a comment at its head, which `told` ends. Raises
    MechanismError for one whose elements stand too deep within each other to be read.
    """
    level, depth = [root], 0
    while level:
        level, depth = [child for one in level for child in one], depth + 1
    if depth > DEEPEST:
        raise MechanismError(
            f"in this format links stand within each other, {depth} deep here; allowed: {DEEPEST}; "
            f"write a mechanism file (.toml), URDF or SDF"
        )
    ElementTree.indent(root, "  ")
    comment = f"{name}, written by symkin: metres and radians; masses have no meaning{told}"
    words = " ".join(comment.replace("--", "- -").split())
    return (
        f'<?xml version="1.0" encoding="utf-8"?>\n<!-- {words} -->\n'
        f"{ElementTree.tostring(root, encoding='unicode')}\n"
    )


def numbers(values: Iterable[float]) -> str:
    """Numbers with spaces between them."""
    return " ".join(number(float(value)) for value in values)


def number(value: float) -> str:
    """The shortest digits that read back as this number."""
    text = repr(value + 0.0)
    return text.removesuffix(".0")


def _text(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float | int):
        return number(float(value))
    return value if isinstance(value, str) else numbers(value)  # type: ignore[arg-type]
