"""A robot as a file of another format describes it: a tree of joints at the file's own configuration, and closures that may be open.

Every reader makes a `Robot`. Points and axes are in the base frame at the file's configuration (all of it placed by the tree's joints), so
that a link's displacement is the product of the exponentials of the joints before it. A closure holds two frames, one on each of its
links, which coincide as its type says where the loop is closed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from symkin.model.graph import Coupling, LinkJoint
from symkin.spatial.pose import Pose

ClosureType = Literal["S", "U", "R", "C", "P", "weld"]
"""What a closure leaves free: S holds a point, weld all; R, C and P have the z axis of the first frame in common, U as in `Joint`."""


@dataclass(frozen=True)
class Closure:
    """A constraint between two `links` that the tree joins in another way: `first` is its frame on the first link, `second` on the
    other, both in the base frame at the file's configuration; `where` names element and line of the file."""

    name: str
    type: ClosureType
    links: tuple[str, str]
    first: Pose
    second: Pose
    where: str = ""


@dataclass(frozen=True)
class Robot:
    """Links by name with their frames at the file's configuration, the tree's `joints` (each from the link that is nearer to the root
    to the other; their `zero` is the value at the file's configuration, in radians and metres), closures, couplings of joints, and what
    was left out of the file, a sentence each (`notes`). The root link is "base"."""

    name: str
    links: Mapping[str, Pose]
    joints: tuple[LinkJoint, ...]
    closures: tuple[Closure, ...] = ()
    couplings: tuple[Coupling, ...] = ()
    notes: tuple[str, ...] = ()
    source: str = ""
    meshes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
