"""What the readers of joints as a graph share: notes on what is left out, ranges, meshes, elements
of no meaning.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from symkin.formats.packages import Packages
from symkin.formats.parts import Parts
from symkin.formats.read_options import ReadOptions
from symkin.formats.robot import Mesh, RobotJoint
from symkin.formats.sdf_joint import UNLIMITED
from symkin.formats.urdf_parts import names_any
from symkin.formats.xml_text import Element
from symkin.spatial.pose import Pose
from symkin.text import first_of

ONE_COORDINATE = ("R", "P", "H")
"""Joints that mimics may follow, and that are driven where nothing says which are."""


class GraphReader:
    """A reader of one file: where it is, what is told beside it and in it of joints in parts, and
    the notes that it makes on the way.
    """

    parts: Parts

    def __init__(self, path: Path, read: ReadOptions) -> None:
        self.path, self.read = path, read
        self.packages = Packages(path, read.folders)
        self.notes: list[str] = []

    def range_of(
        self, limits: tuple[float, float] | None, element: Element, line: int
    ) -> tuple[float, float] | None:
        """Bounds that are a range; None for others, with a note where they bound anything."""
        if limits is None:
            return None
        low, high = limits
        if -UNLIMITED < low < high < UNLIMITED:
            return limits
        if low > -UNLIMITED or high < UNLIMITED:
            why = (
                "its upper end is not above its lower one" if low >= high else "it has no two ends"
            )
            self.notes.append(
                f"line {line}: the range [{low:g}, {high:g}] of {element.label} is left out; {why}"
            )
        return None

    @property
    def motors_told(self) -> bool:
        """Whether it is told elsewhere which joints are actuated."""
        return bool(self.read.actuated) or self.parts.actuated is not None

    def driven(
        self,
        joints: Sequence[RobotJoint],
        named: Collection[str],
        tree: Collection[str],
        followers: Collection[str],
        notes: list[str],
    ) -> list[RobotJoint]:
        """The joints, actuated where they are `named` and move about axes (a note tells others),
        but for followers of others where any leads; where none is, all of one coordinate of the
        tree, with a note.
        """
        kinds = {j.name: j.type for j in joints if j.name in named}
        named = {name for name, kind in kinds.items() if kind in (*ONE_COORDINATE, "U")}
        if idle := [f"{name!r} ({kind})" for name, kind in kinds.items() if name not in named]:
            notes.append(
                f"named as driven, but of a type that no one motor drives: {first_of(idle)}"
            )
        driven = named.difference(followers) or named
        if not driven:
            able = set(tree).difference(followers)
            driven = {j.name for j in joints if j.name in able and j.type in ONE_COORDINATE}
            if driven:
                notes.append(
                    "no motors are told: all movable joints of the tree of one coordinate are "
                    "actuated"
                )
        return [replace(j, actuated=True) if j.name in driven else j for j in joints]

    def meshes(self, link: Element, made: Callable[[Element, Element], Mesh]) -> tuple[Mesh, ...]:
        """The meshes that show a link, each made of its <visual> and itself."""
        return tuple(
            made(visual, mesh)
            for visual in link.all("visual")
            for mesh in visual.walk()
            if mesh.tag == "mesh"
        )

    def mesh(self, element: Element, uri: str, pose: Pose, scale: tuple[float, ...]) -> Mesh:
        """A reference to a mesh, which need not be there. Raises MechanismError for a scale of
        0.
        """
        if 0.0 in scale:
            raise element.error(
                f"scale = {list(scale)} makes nothing of the mesh; numbers other than 0 are needed"
            )
        x, y, z = scale
        return Mesh(self.packages.written(uri), pose, (x, y, z))

    def left_out(
        self,
        elements: Iterable[Element],
        meanings: Mapping[str, str],
        names: set[str],
        within: str = "",
    ) -> list[str]:
        """A note on elements of no meaning here. Raises MechanismError for an unknown one that
        names links or joints.
        """
        found: dict[str, None] = {}
        for element in elements:
            if element.tag not in meanings and names_any(element, names):
                raise element.error(
                    f"<{element.tag}> is unknown{within}, and it names links or joints of the "
                    f"robot; remove it if it is no constraint"
                )
            found[meanings.get(element.tag, f"<{element.tag}>")] = None
        return [f"left out, of no meaning here: {', '.join(found)}"] if found else []
