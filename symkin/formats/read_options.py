"""What is told beside a file: parameters of a mechanism file; of a robot kinds of closures,
actuated joints, the platform's link, arguments of xacro, packages, the model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

from symkin.errors import InputError
from symkin.model.joint import BASE
from symkin.text import first_of, meant, shown

if TYPE_CHECKING:
    from symkin.formats.robot import Robot, RobotJoint
    from symkin.model.joint_forms import JointType

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_DRIVEN = ("R", "P", "H", "C", "U")
"""Joints that may be actuated."""
_CLOSURES: tuple[JointType, ...] = ("S", "U", "R", "C", "P", "weld")
"""Kinds that may be told; a screw takes its pitch as well, which the file must tell."""


@dataclass(frozen=True)
class ReadOptions:
    """What is told beside a file to `load`, `close` and `convert`: parameters of a mechanism file,
    and what the file of a robot in a format of others leaves out.

    `set`: numbers of `[parameters]`, or arithmetic, in place of the file's. `loop`: the kind of
    closures by name, R, S, C, P, U or weld, about or along the z axis of their frames; "R:x" names
    another of its axes (x, y, z). `actuated`: names of the joints that motors drive, in place of
    what the file tells. `platform`: the link (or a body that a fixed joint makes part of one) whose
    own frame is the platform frame, so that poses can be given and told; its `[platform]`.
    `arguments`: those of a file in xacro. `packages`: folders that are packages or hold them, for
    `package://NAME`, `model://NAME` and `$(find NAME)`. `model`: which model of an SDF file. Raises
    InputError, when the file is read, for what does not fit it.

    >>> import symkin
    >>> symkin.ReadOptions(loop={"closing_knee": "R:x"}, actuated=["hip"]).actuated
    ('hip',)
    """

    loop: Mapping[str, str] = field(default_factory=dict)
    actuated: Sequence[str] = ()
    platform: str | None = None
    arguments: Mapping[str, str] = field(default_factory=dict)
    packages: Sequence[Path | str] = ()
    model: str | None = None
    set: Mapping[str, float | str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for key in ("loop", "arguments", "set"):
            value = getattr(self, key)
            if not isinstance(value, Mapping):
                raise InputError(f"{key} = {shown(value)}; a mapping of names to values is needed")
            object.__setattr__(self, key, dict(value))
        for key in ("actuated", "packages"):
            value = getattr(self, key)
            if isinstance(value, str):
                raise InputError(f"{key} = {shown(value)} is one text; a list is needed")
            object.__setattr__(self, key, tuple(value))
        for name, kind in self.loop.items():
            _closure_kind(name, kind)

    @property
    def folders(self) -> tuple[Path, ...]:
        """The folders of packages. Raises InputError for one that is none."""
        found = tuple(Path(folder) for folder in self.packages)
        missing = next((folder for folder in found if not folder.is_dir()), None)
        if missing is not None:
            raise InputError(
                f"packages: {shown(str(missing))} is no folder; name a package, or a folder that "
                f"holds packages"
            )
        return found

    def refuse_but(self, allowed: Sequence[str], what: str, because: str) -> None:
        """Raise InputError for options that are given and mean nothing for a file; `because` says
        why.
        """
        given = [option.name for option in fields(self) if getattr(self, option.name)]
        wrong = next((key for key in given if key not in allowed), None)
        if wrong == "set":
            because = "parameters are those of a mechanism file (.toml), in its [parameters]"
        if wrong is not None:
            raise InputError(f"{wrong} (--{wrong}) has no meaning for {what}: {because}")

    def told(self, robot: Robot) -> Robot:
        """The robot with the closures' kinds, actuated joints and platform that are told. Raises
        InputError for unknown names.
        """
        if self.loop:
            robot = _with_kinds(robot, self.loop)
        if self.platform is not None:
            robot = _with_platform(robot, self.platform)
        return _with_motors(robot, self.actuated) if self.actuated else robot


AS_IT_IS = ReadOptions()
"""Nothing is told beside the file."""


def _closure_kind(name: str, told: str) -> tuple[JointType, str]:
    """Kind and axis of a text such as R or R:x."""
    kinds = {kind.lower(): kind for kind in _CLOSURES}
    word, colon, axis = told.strip().partition(":")
    kind = kinds.get(word.strip().lower())
    if kind is None or (colon and axis.strip().lower() not in _AXES):
        raise InputError(
            f"loop: {name} = {shown(told)} is no kind of closure; allowed: "
            f"{', '.join(kinds.values())}, and behind them :x, :y or :z "
            "for the axis in its frames"
        )
    if colon and kind in ("S", "weld"):
        raise InputError(
            f"loop: {name} = {shown(told)} names an axis, and {kind} has none; write {kind}"
        )
    return kind, axis.strip().lower() or "z"


def _with_kinds(robot: Robot, told: Mapping[str, str]) -> Robot:
    names = [closure.joint.name for closure in robot.closures]
    for name in told:
        if name in names:
            continue
        if any(entry.joint.name == name for entry in robot.tree):
            raise InputError(
                f"loop: {name!r} is a joint of the tree and closes no loop; closures: "
                f"{first_of(names) or 'none'}"
            )
        raise InputError(
            f"loop: no closure is named {shown(name)}{meant(name, names)}; closures: "
            f"{first_of(names, 20) or 'none'}"
        )
    joints = tuple(
        _of_kind(e, *_closure_kind(e.joint.name, told[e.joint.name])) if e.joint.name in told else e
        for e in robot.joints
    )
    notes = (
        f"the closure {e.joint.name!r} is of type {e.joint.type}, as told"
        for e in joints
        if e.joint.name in told
    )
    return replace(robot, joints=joints, notes=(*robot.notes, *notes))


def _of_kind(closure: RobotJoint, kind: JointType, axis: str) -> RobotJoint:
    """The closure as one of another kind, about or along an axis of its frames; ranges and motors
    were those of the other kind.
    """
    from symkin.formats.joint_graph import frame_along
    from symkin.formats.robot import joint_at

    turn, joint = frame_along(_AXES[axis]), closure.joint
    keys = ("pitch", "limits", "actuated", "motor") if kind == joint.type else ()
    told = {key: getattr(joint, key) for key in keys}
    first, second = (frame @ turn for frame in closure.frames or ())
    return replace(closure, joint=joint_at(first, joint.name, kind, **told), frames=(first, second))


def _with_platform(robot: Robot, name: str) -> Robot:
    """The robot whose platform frame is that of a link, or of a body that is part of one."""
    frames = {link: (link, frame) for link, frame in robot.links.items()} | dict(robot.merged)
    moved = [body for body, (link, _) in frames.items() if link != BASE]
    if name not in moved:
        if name in frames or any(
            note.startswith(f"the root link {name!r} ") for note in robot.notes
        ):
            raise InputError(
                f"platform: {name!r} is part of the base, which is held; links that move: "
                f"{first_of(moved, 20)}"
            )
        raise InputError(
            f"platform: no link is named {shown(name)}{meant(name, moved)}; links that move: "
            f"{first_of(moved, 20)}"
        )
    return replace(robot, parts=replace(robot.parts, platform=frames[name]))


def _with_motors(robot: Robot, names: Sequence[str]) -> Robot:
    kinds = {entry.joint.name: entry.joint.type for entry in robot.joints}
    able = [name for name, kind in kinds.items() if kind in _DRIVEN]
    for name in names:
        if name not in kinds:
            raise InputError(
                f"actuated: no joint is named {shown(name)}{meant(name, able)}; joints that may "
                f"be: {first_of(able, 20)}"
            )
        if name not in able:
            raise InputError(
                f"actuated: {name!r} is of type {kinds[name]}, which no one motor drives; joints "
                f"that may be: {first_of(able, 20)}"
            )
        if names.count(name) > 1:
            raise InputError(f"actuated: {name!r} is given twice")
    driven = (replace(entry.joint, actuated=entry.joint.name in names) for entry in robot.joints)
    return replace(
        robot,
        joints=tuple(
            replace(entry, joint=joint) for entry, joint in zip(robot.joints, driven, strict=True)
        ),
        parts=replace(robot.parts, actuated=None),
    )
