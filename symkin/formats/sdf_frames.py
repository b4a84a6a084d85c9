"""Frames of an SDF file: links, joints, named frames and nested models, each told in another one;
where all of them are in the world.

A name within a nested model is `model::name`. What a pose is told in, where it does not say: a
link, a frame or a nested model in its model's frame, a frame that is attached in the frame it is
attached to, a joint in its child.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from symkin.errors import InputError
from symkin.formats.packages import Packages
from symkin.formats.robot import MOST_JOINTS
from symkin.formats.urdf_parts import turned_pose
from symkin.formats.xml_text import Element, is_true, read_xml
from symkin.model.mechanism import MOST_PARTS
from symkin.spatial.pose import Pose
from symkin.text import meant

Version = tuple[int, int]
OLDEST, NEWEST = (1, 4), (1, 12)
"""Versions of SDF whose rules are known here."""
FIRST_WITH_FRAMES = (1, 7)
"""From this version on relative_to and expressed_in name frames; before it `frame` on a pose had no
meaning.
"""
WORLD = "world"
_MODEL = "__model__"
_MOST_FRAMES = 3 * MOST_JOINTS
"""Links, joints, models and frames of a file and those that it includes: as many of each as joints
may be.
"""
_MOST_FILES = 20
"""Files within each other."""


@dataclass(frozen=True)
class Scope:
    """A model: what its names begin with, its own frame, the version of the file that tells it, and
    whether it is held in the world (static), with all models in it.
    """

    prefix: str
    model: str
    version: Version
    element: Element
    files: tuple[Path, ...]
    held: bool = False


@dataclass(frozen=True)
class _Frame:
    """A frame: its pose in another one, what it is attached to, and for a model placed by one of
    its frames that frame.
    """

    pose: Pose
    told_in: str
    attached: str
    element: Element
    placement: str | None = None


@dataclass
class SdfFrames:
    """All frames of a file by their full names; links and joints in order with the model in which
    they stand.
    """

    packages: Packages
    frames: dict[str, _Frame] = field(default_factory=dict)
    links: dict[str, tuple[Element, Scope]] = field(default_factory=dict)
    joints: list[tuple[Element, Scope]] = field(default_factory=list)
    includes: int = 0
    roots: dict[Path, Element] = field(default_factory=dict)
    scopes: list[Scope] = field(default_factory=list)
    known: dict[tuple[str, str], Pose] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def add_model(
        self,
        element: Element,
        scope: Scope,
        outer: Scope | None = None,
        placed: Element | None = None,
    ) -> None:
        """A model and all within it, in an outer one; `placed` is the include that places it in
        another way.
        """
        self.scopes.append(scope)
        links = element.all("link")
        nested = element.all("model")
        if placed is not None and outer is not None and placed.one("pose") is not None:
            pose, name = sdf_pose(placed, outer.version)
        else:
            pose, name = sdf_pose(element, scope.version)
            name = name if placed is None else None
        told_in = name or WORLD
        if outer is not None:
            told_in = outer.model if name is None else self._written(name, outer)
        canonical = element.attributes.get("canonical_link") or next(
            (name for e in (*links, *nested) if (name := e.attribute("name")) != WORLD), _MODEL
        )
        word = element.attributes.get("placement_frame", "")
        word = word if placed is None else placed.child_text("placement_frame", word)
        attached = WORLD if scope.held or canonical == _MODEL else scope.prefix + canonical
        placement = scope.prefix + word if word else None
        self.frames[scope.model] = _Frame(pose, told_in, attached, element, placement)
        for link in links:
            if self._is_the_world(link, scope):
                continue
            key = self._new(scope.prefix + link.attribute("name"), link)
            self.frames[key] = self._placed(link, scope, scope.model, key)
            self.links[key] = link, scope
            if scope.held:
                self._add_joint(_held(link), scope)
        for frame_element in element.all("frame"):
            self._add_frame(frame_element, scope)
        for child in nested:
            self._add_nested(child, scope)
        for include in element.all("include"):
            self._include(include, scope)
        for joint in element.all("joint"):
            self._add_joint(joint, scope)

    def pose(self, name: str, end: str = WORLD) -> Pose:
        """A frame's pose in the world, or in a frame above it; those on the way there are kept."""
        path: list[str] = []
        at = self._full(name)
        while at != end and (at, end) not in self.known:
            self._refuse_circle(at, path, name)
            path.append(at)
            at = self._full(self.frames[at].told_in)
            if at == WORLD != end:
                raise self.frames[path[-1]].element.error(
                    f"the frame {name!r} does not stand within the model that it places"
                )
        pose = self.known.get((at, end), Pose.identity())
        for key in reversed(path):
            pose = self.known[key, end] = pose @ self._own(key)
        return pose

    def link_of(self, name: str) -> str:
        """The link that carries a frame, or the world."""
        seen: list[str] = []
        while name != WORLD and name not in self.links:
            name = self._full(name)
            if name in seen:
                raise self.frames[name].element.error(
                    "the frames are attached to each other in a circle"
                )
            seen.append(name)
            name = self.frames[name].attached if name != WORLD and name not in self.links else name
        return name

    def find(self, name: str, scope: Scope, element: Element) -> str:
        """The full name of what a model calls `name`. Raises MechanismError where there is
        nothing.
        """
        if name == WORLD:
            return WORLD
        if name == _MODEL:
            return scope.model
        known = self._full(scope.prefix + name)
        if known not in self.frames:
            own = [key[len(scope.prefix) :] for key in self.frames if key.startswith(scope.prefix)]
            raise element.error(f"the frame {name!r} is unknown{meant(name, own)}")
        return known

    def relative(self, element: Element, scope: Scope, default: str) -> tuple[Pose, str]:
        """The pose of an element, and the full name of the frame in which it is told."""
        pose, name = sdf_pose(element, scope.version)
        return pose, default if name is None else self.find(name, scope, element)

    # --- parts ------------------------------------------------------------------------------------

    def _placed(self, element: Element, scope: Scope, default: str, attached: str) -> _Frame:
        pose, name = sdf_pose(element, scope.version)
        told_in = default if name is None else self._written(name, scope)
        return _Frame(pose, told_in, attached, element)

    def _is_the_world(self, link: Element, scope: Scope) -> bool:
        """Whether a link is what the model stands in, which only files before 1.7 write. Raises
        MechanismError for later ones.
        """
        if link.attribute("name") != WORLD or scope.prefix:
            return False
        pose, _ = sdf_pose(link, scope.version)
        if scope.version >= FIRST_WITH_FRAMES or pose.position.any() or pose.quaternion[1:].any():
            raise link.error(
                f"the name {WORLD!r} is reserved for what the model stands in; give the link "
                f"another name"
            )
        self.notes.append(
            f"line {link.line}: the link {WORLD!r} is what the model stands in, and is held"
        )
        return True

    def _written(self, name: str, scope: Scope) -> str:
        """The full name of a frame that may stand further down in the file."""
        return {WORLD: WORLD, _MODEL: scope.model}.get(name, scope.prefix + name)

    def _add_frame(self, element: Element, scope: Scope) -> None:
        name = element.attributes.get("attached_to", "").strip()
        if scope.version < FIRST_WITH_FRAMES and not name:
            return
        attached = self._written(name, scope) if name else scope.model
        key = self._new(scope.prefix + element.attribute("name"), element)
        self.frames[key] = self._placed(element, scope, attached, attached)

    def _add_joint(self, element: Element, scope: Scope) -> None:
        self.joints.append((element, scope))
        key = scope.prefix + element.attribute("name")
        if key not in self.frames:
            child = self._written(element.needed("child").text.strip(), scope)
            self.frames[key] = self._placed(element, scope, child, child)

    def _add_nested(self, element: Element, scope: Scope) -> None:
        prefix = f"{scope.prefix}{element.attribute('name')}::"
        key = self._new(prefix + _MODEL, element)
        held = scope.held or is_static(element)
        inner = Scope(prefix, key, scope.version, element, scope.files, held)
        self.add_model(element, inner, scope)

    def _include(self, element: Element, scope: Scope) -> None:
        """The model of another file, under its own name or that of the include, or merged into this
        model.
        """
        path = _included(element, scope.files, self.packages)
        self.includes += 1
        if self.includes > MOST_PARTS:
            raise element.error(
                f"it is include number {self.includes}, with those of included files; allowed: "
                f"{MOST_PARTS}"
            )
        root = self.roots[path] = self.roots.get(path) or read_xml(path, "sdf")
        model = root.needed("model")
        given = element.one("name")
        name = given.text.strip() if given is not None else model.attribute("name")
        merged = is_true(element.attributes.get("merge", ""))
        prefix = scope.prefix if merged else f"{scope.prefix}{name}::"
        key = self._new(
            f"{scope.prefix}_merged__{name}__model__" if merged else prefix + _MODEL, element
        )
        held = scope.held or is_static(model if element.one("static") is None else element)
        inner = Scope(prefix, key, sdf_version(root), model, (*scope.files, path), held)
        self.add_model(model, inner, scope, placed=element)

    def _new(self, key: str, element: Element) -> str:
        if len(self.frames) >= _MOST_FRAMES:
            raise element.error(
                f"the file has more than {_MOST_FRAMES} links, frames and models; no robot has so "
                f"many"
            )
        if key in self.frames or key == WORLD:
            raise element.error(
                f"the name {key!r} is taken; names of links, frames and models must be unique"
            )
        return key

    def _full(self, key: str) -> str:
        """The frame of a nested model, by the model's name."""
        return (
            f"{key}::{_MODEL}"
            if key not in self.frames and f"{key}::{_MODEL}" in self.frames
            else key
        )

    def _own(self, key: str) -> Pose:
        """A frame's pose in the one in which it is told."""
        frame = self.frames[key]
        return (
            frame.pose
            if frame.placement is None
            else frame.pose @ self.pose(frame.placement, key).inverse()
        )

    def _refuse_circle(self, at: str, path: Sequence[str], name: str) -> None:
        """Raise MechanismError for a frame that is unknown, or has been passed."""
        last = self.frames.get(path[-1] if path else name)
        if at not in self.frames:
            element = last.element if last is not None else next(iter(self.frames.values())).element
            raise element.error(
                f"the frame {at!r} in which it is told is unknown{meant(at, self.frames)}"
            )
        if last is not None and len(path) > len(self.frames):
            raise last.element.error("the poses of frames are told in each other in a circle")


def sdf_version(root: Element) -> Version:
    """The version of a file, of those that are known."""
    text = root.attribute("version")
    match = re.fullmatch(r"([0-9]{1,3})\.([0-9]{1,3})(\.[0-9]{1,3})*", text)
    found = (int(match[1]), int(match[2])) if match else (0, 0)
    if not OLDEST <= found <= NEWEST:
        raise root.error(
            f"version = {text!r} is unknown; allowed: {OLDEST[0]}.{OLDEST[1]} to "
            f"{NEWEST[0]}.{NEWEST[1]}"
        )
    return found


def sdf_pose(element: Element, version: Version) -> tuple[Pose, str | None]:
    """The child <pose>, and the name of the frame in which it is told where it names one; the
    identity where there is none.
    """
    pose = element.one("pose")
    if pose is None:
        return Pose.identity(), None
    told_in = pose.attributes.get("relative_to", "").strip() or None
    old = pose.attributes.get("frame", "").strip()
    if old:
        raise pose.error(
            f"poses of version {version[0]}.{version[1]} are not told in the frame {old!r}; write "
            f"relative_to"
        )
    if not pose.text.strip():
        return Pose.identity(), told_in
    if pose.attributes.get("rotation_format", "euler_rpy").strip() == "quat_xyzw":
        x, y, z, *xyzw = pose.text_numbers(7)
        return turned_pose(pose, (x, y, z), xyzw), told_in
    x, y, z, *angles = pose.text_numbers(6)
    scale = math.pi / 180 if is_true(pose.attributes.get("degrees", "")) else 1.0
    return Pose.from_euler((x, y, z), [scale * angle for angle in angles], "xyz"), told_in


def is_static(model: Element) -> bool:
    """Whether a model, or an include of one, stands still in the world."""
    return is_true(model.child_text("static"))


def _held(link: Element) -> Element:
    """A fixed joint from the world to a link, at the link's place in the file."""
    name, place = link.attribute("name"), (link.file, link.line)
    told = {"parent": WORLD, "child": name}
    ends = [Element(tag, {}, *place, text=text) for tag, text in told.items()]
    return Element("joint", {"name": f"static {name}", "type": "fixed"}, *place, children=ends)


def _included(element: Element, files: Sequence[Path], packages: Packages) -> Path:
    """The file that an include names: in a folder of packages, beside this file or above it, a
    folder with model.sdf or a file.
    """
    uri = element.needed("uri").text.strip()
    name = uri.removeprefix("model://").removeprefix("package://").removeprefix("file://")
    here, first = files[-1].parent, Path(name).parts[:1]
    own = [folder.parent for folder in packages.folders if (folder.resolve().name,) == first]
    folders = [*packages.folders, *own, here, *list(here.parents)[:2]]
    tries = [folder / name / end for end in ("", "model.sdf") for folder in folders]
    found = next((path.resolve() for path in tries if path.is_file()), None)
    if found is None:
        raise InputError(
            f"{element.where}: the included model {uri!r} is not found beside the file, in the two "
            f"folders above it or in a folder of "
            "packages (--packages)"
        )
    if found in [file.resolve() for file in files]:
        raise element.error(f"{uri!r} includes itself")
    if len(files) >= _MOST_FILES:
        raise element.error(f"more than {_MOST_FILES} files include each other")
    return found
