"""Read MJCF, the XML of MuJoCo, as a robot: bodies, joints, equality constraints, fixed tendons,
and which joints actuators drive.

MuJoCo's own compiler resolves defaults, classes, includes, frames and angles, in a process of its
own (`formats/mujoco_worker.py`); what is read is the compiled model at qpos0. Meshes and inertias
are never needed: the first need not be there, the second are replaced. What constraints and tendons
mean is MuJoCo's documentation, "XML reference: equality", and `mj_instantiateEqual` of its source.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from symkin.errors import InputError, MechanismError
from symkin.formats.child import ChildError, answer_of
from symkin.formats.mjcf_model import CompiledModel, compiled_model
from symkin.formats.mjcf_reader import Reader
from symkin.formats.read_options import AS_IT_IS, ReadOptions
from symkin.formats.robot import Robot, refuse_too_many
from symkin.formats.spanning import names_of, spanned, uniquely_named
from symkin.formats.xml_text import end_of_root, read_text, read_xml
from symkin.spatial.pose import Pose
from symkin.text import printable

_WORKER = Path(__file__).with_name("mujoco_worker.py")
_INSTALL = (
    "reading MJCF takes MuJoCo's compiler, which is not installed; pip install 'symkin[mjcf]' "
    "brings it"
)


def read_mjcf(path: Path, read: ReadOptions = AS_IT_IS) -> Robot:
    """The robot that an MJCF file describes, at the file's own configuration (qpos0).

    Raises InputError for a file that cannot be read or without the package `mujoco`, MechanismError
    for a file that is not right: file, line and element as MuJoCo's compiler tells them.
    """
    told = uniquely_named(_reader(path, read).robot())
    robot, order = spanned(told), [*names_of(told)[1].values()]
    # MuJoCo's order: that of bodies within each other
    joints = sorted(robot.told, key=lambda joint: (joint.closing, order.index(joint.name)))
    return replace(robot, told=joints)


def with_keyframe(
    path: Path, joints: Mapping[str, float | Sequence[float]], poses: Mapping[str, Pose]
) -> bytes:
    """The content of an MJCF file, in its own encoding, with one more keyframe, "closed": the
    values of its joints, and poses of links that hang on no joint.
    """
    reader = _reader(path)
    content = read_text(path)
    end = end_of_root(content, str(path))
    used = {e.attributes.get("name", "") for e in reader.compiled.root.walk() if e.tag == "key"}
    name = next(
        name
        for k in range(1, len(used) + 3)
        if (name := "closed" if k == 1 else f"closed_{k}") not in used
    )
    numbers = " ".join(repr(float(value) + 0.0) for value in reader.positions(joints, poses))
    if not numbers:
        raise InputError(f"{path} has no joint whose value a keyframe could hold; give a .json")
    frame = f'  <keyframe>\n    <key name="{name}" qpos="{numbers}"/>\n  </keyframe>\n'
    return content[:end] + frame.encode() + content[end:]


def _reader(path: Path, read: ReadOptions = AS_IT_IS) -> Reader:
    """The compiled model, ready to be read."""
    root = read_xml(path, "mujoco")
    told = _told(path)
    joints = len(told["joints"])
    refuse_too_many(str(path), max(len(told["bodies"]), joints, len(told["equalities"])), joints)
    compiled = compiled_model(told, root, path)
    _check_finite(compiled)
    return Reader(compiled, motors_told=bool(read.actuated))


def _told(path: Path) -> dict[str, Any]:
    """What MuJoCo's compiler makes of a file."""
    if find_spec("mujoco") is None:
        raise InputError(_INSTALL)
    if printable(str(path)) != str(path):
        raise InputError(f"{path}: MuJoCo's compiler reads no file whose path is not plain text")
    try:
        told: dict[str, Any] = answer_of(_WORKER, {"path": str(path)})
    except ChildError as error:
        raise MechanismError(f"{path}: MuJoCo's compiler {error}") from None
    if "error" in told:
        raise MechanismError(f"{path}: {_sentence(told['error'])}")
    return told


def _sentence(message: str) -> str:
    """The compiler's message in one line."""
    text = re.sub(r"\s+", " ", message).strip()
    return re.sub(r"^(XML )?(Error: )+", "", text).replace("Element name '', id", "element").strip()


def _check_finite(compiled: CompiledModel) -> None:
    """Raises MechanismError for numbers that are none, which the compiler lets through."""
    if compiled.finite:
        return
    guilty = next(
        (
            e
            for e in compiled.root.walk()
            for v in e.attributes.values()
            if {"nan", "inf", "-inf"} & set(v.lower().split())
        ),
        None,
    )
    place = str(compiled.path) if guilty is None else guilty.where
    raise MechanismError(f"{place}: a number is not finite; allowed: numbers such as 0.25 or 1e-3")
