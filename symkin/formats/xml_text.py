"""Read XML that others wrote: elements with their lines, no entities, no document types, bounded in
size and depth.

An `Element` is asked for what it must hold; what is missing or no number is one sentence with file,
line and element.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from symkin.errors import MechanismError
from symkin.regular_file import content_of
from symkin.text import first_of, shown

LARGEST_FILE = 8_000_000
"""Bytes of a file: descriptions of robots have a tenth of it at most, meshes stand beside them."""
DEEPEST = 200
"""Elements within each other: models within models have ten, and what walks over them calls
itself.
"""
_NUMBER = re.compile(
    r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|[-+]?inf(?:inity)?", re.IGNORECASE
)
_LATE_DECLARATION = re.compile(rb"\A\s+<\?xml[^>]*\?>")
"""The declaration of XML behind empty lines, which other readers take; the text is UTF-8 then."""
_FORMATS = {"robot": ("URDF", ".urdf"), "sdf": ("SDF", ".sdf"), "mujoco": ("MJCF", ".xml")}
"""Formats by their first element."""
_NAMED = 40
"""Characters of a name that tells an element from others in a message."""


@dataclass(eq=False)
class Element:
    """An element of an XML file: its tag as written, attributes, children in order, and its
    text.
    """

    tag: str
    attributes: Mapping[str, str]
    file: str
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""

    @property
    def where(self) -> str:
        """File, line and element, for messages."""
        return f"{self.file}: line {self.line}: {self.label}"

    @property
    def label(self) -> str:
        """The element as a person finds it: <joint name='knee'>."""
        for name in ("name", "link", "joint"):
            if name in self.attributes:
                return f"<{self.tag} {name}={shown(self.attributes[name][:_NAMED])}>"
        return f"<{self.tag}>"

    def error(self, message: str) -> MechanismError:
        """An error whose sentence begins with file, line and element."""
        return MechanismError(f"{self.where}: {message}")

    def all(self, *tags: str) -> list[Element]:
        """The children of these tags, in order."""
        return [child for child in self.children if child.tag in tags]

    def one(self, tag: str) -> Element | None:
        """The child of this tag, None where there is none. Raises MechanismError where there are
        two.
        """
        found = self.all(tag)
        if len(found) > 1:
            raise found[1].error(f"stands twice in {self.label}; one is allowed")
        return found[0] if found else None

    def needed(self, tag: str) -> Element:
        """The child of this tag. Raises MechanismError where there is none."""
        found = self.one(tag)
        if found is None:
            raise self.error(f"<{tag}> is missing")
        return found

    def attribute(self, *names: str) -> str:
        """The value of the first of these attributes that is there, without spaces around it.
        Raises MechanismError for none.
        """
        value = next(
            (self.attributes[name].strip() for name in names if name in self.attributes), None
        )
        if not value:
            raise self.error(
                f"the attribute {' or '.join(names)} is {'missing' if value is None else 'empty'}"
            )
        return value

    def number(self, name: str, default: float | None = None, *, infinite: bool = False) -> float:
        """The number in an attribute; `default` where there is none."""
        if default is not None and name not in self.attributes:
            return default
        return self._number(self.attribute(name), name, infinite)

    def numbers(
        self, name: str, count: int, default: Sequence[float] | None = None
    ) -> tuple[float, ...]:
        """The numbers in an attribute; `default` where there is none."""
        if default is not None and name not in self.attributes:
            return tuple(default)
        return self._numbers(self.attribute(name), name, count)

    def text_numbers(self, count: int) -> tuple[float, ...]:
        """The numbers in the element's text."""
        return self._numbers(self.text, "the text", count)

    def text_number(self, *, infinite: bool = False) -> float:
        """The number in the element's text."""
        return self._number(self.text, "the text", infinite)

    def child_text(self, tag: str, default: str = "") -> str:
        """The text of the child of this tag, without spaces around it; `default` where there is
        none.
        """
        child = self.one(tag)
        return default if child is None else child.text.strip()

    def child_number(self, tag: str, default: float, *, infinite: bool = False) -> float:
        """The number in the text of the child of this tag; `default` where there is none."""
        child = self.one(tag)
        return default if child is None else child.text_number(infinite=infinite)

    def walk(self) -> Iterator[Element]:
        """The element and all within it, in the file's order."""
        todo = [self]
        while todo:
            element = todo.pop()
            yield element
            todo.extend(reversed(element.children))

    def _numbers(self, text: str, what: str, count: int) -> tuple[float, ...]:
        words = text.split()
        if len(words) != count:
            raise self.error(
                f"{what} = {shown(text.strip())} has {len(words)} numbers; {count} are needed, "
                f"spaces between them"
            )
        return tuple(self._number(word, what, infinite=False) for word in words)

    def _number(self, text: str, what: str, infinite: bool) -> float:
        word = text.strip()
        value = float(word) if _NUMBER.fullmatch(word) else math.nan
        if math.isnan(value) or (math.isinf(value) and not infinite):
            raise self.error(
                f"{what} = {shown(word)} is not a finite number; allowed: numbers such as 0.25 or "
                f"1e-3"
            )
        return value


def is_true(text: str) -> bool:
    """Whether a text is a flag that is set."""
    return text.strip().lower() in ("1", "true")


def read_xml(path: Path, *roots: str) -> Element:
    """The root element of an XML file, which has one of the tags `roots`.

    Raises InputError for a file that cannot be read, MechanismError for one that is no XML, is too
    large, too deep, declares a document type (entities) or has another root.
    """
    return parse_xml(read_text(path), str(path), *roots)


def parse_xml(content: bytes, file: str, *roots: str) -> Element:
    """The root element of an XML text, of any tag where `roots` are none; `file` names it in
    messages.
    """
    if len(content) > LARGEST_FILE:
        raise MechanismError(
            f"{file}: the file has more than {LARGEST_FILE / 1e6:g} MB, which are allowed for the "
            f"description of a robot; leave "
            "meshes and other data out of it"
        )
    if not content.strip():
        raise MechanismError(
            f"{file}: the file is empty; the element {_choice(roots or ['robot'])} is needed"
        )
    root = _Builder(file).root(content)
    if roots and root.tag not in roots:
        remedy = ""
        if root.tag in _FORMATS:
            form, suffix = _FORMATS[root.tag]
            remedy = f"; the file is {form}, and its name should end in {suffix}"
        raise root.error(
            f"the file's first element is <{root.tag}>; {_choice(roots)} is needed{remedy}"
        )
    return root


def end_of_root(content: bytes, file: str) -> int:
    """Where the end tag of an XML text's first element begins, in bytes."""
    builder = _Builder(file)
    builder.root(content)
    return builder.last_end


class _Builder:
    """What the parser tells, as a tree of elements."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.open: list[tuple[Element, list[str]]] = []
        self.first: Element | None = None
        self.last_end = 0
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self.parser.StartDoctypeDeclHandler = self._document_type

    def root(self, content: bytes) -> Element:
        try:
            late = _LATE_DECLARATION.match(content)
            blank = re.sub(rb"[^\n]", b" ", late[0]) if late else b""
            self.parser.Parse(blank + content[len(blank) :], True)
        except expat.ExpatError as error:
            reason = expat.ErrorString(error.code)
            raise MechanismError(
                f"{self.file}: line {error.lineno}: not XML: {reason} (column {error.offset + 1})"
            ) from None
        except (LookupError, ValueError) as error:
            raise MechanismError(
                f"{self.file}: line 1: not XML: {' '.join(str(error).split())}"
            ) from None
        if self.first is None:
            raise MechanismError(f"{self.file}: line 1: not XML: no element is found")
        return self.first

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, self.file, self.parser.CurrentLineNumber)
        if self.open:
            self.open[-1][0].children.append(element)
        else:
            self.first = element
        self.open.append((element, []))
        if len(self.open) > DEEPEST:
            raise element.error(
                f"the elements stand more than {DEEPEST} within each other; no description of a "
                f"robot is so deep"
            )

    def _end(self, _tag: str) -> None:
        self.last_end = self.parser.CurrentByteIndex
        element, texts = self.open.pop()
        element.text = "".join(texts)

    def _text(self, text: str) -> None:
        self.open[-1][1].append(text)

    def _document_type(self, *_declaration: object) -> None:
        raise MechanismError(
            f"{self.file}: line {self.parser.CurrentLineNumber}: <!DOCTYPE>: document types and "
            f"entities are not read; write their "
            "text where they are used"
        )


def read_text(path: Path) -> bytes:
    """A file's content, at most one byte more than is allowed. Raises InputError for one that
    cannot be read.
    """
    return content_of(path, LARGEST_FILE + 1)


def _choice(tags: Sequence[str]) -> str:
    return first_of([f"<{tag}>" for tag in tags]).replace(", ", " or ")
