"""Read MJCF, the XML of MuJoCo, as a robot: bodies, joints, equality constraints, fixed tendons, and which joints actuators drive.

MuJoCo's own compiler resolves defaults, classes, includes, frames and angles; what is read is the compiled model at qpos0. Meshes and
inertias are never needed: the first need not be there, the second are replaced. What constraints and tendons mean is MuJoCo's
documentation, "XML reference: equality", and `mj_instantiateEqual` of its source.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from threading import Lock
from types import ModuleType
from typing import Any

import numpy as np

from symkin.errors import InputError, MechanismError
from symkin.formats.mjcf_model import CompiledModel
from symkin.formats.mjcf_reader import Reader
from symkin.formats.packages import Packages
from symkin.formats.read_options import AS_IT_IS, ReadOptions
from symkin.formats.robot import Mesh, Robot
from symkin.formats.xml_text import Element, read_xml
from symkin.spatial.pose import Pose

_INSTALL = "reading MJCF takes MuJoCo's compiler, which is not installed; pip install 'symkin[mjcf]' brings it"


def read_mjcf(path: Path, read: ReadOptions = AS_IT_IS) -> Robot:
    """The robot that an MJCF file describes, at the file's own configuration (qpos0).

    Raises InputError for a file that cannot be read or without the package `mujoco`, MechanismError for a file that is not right:
    file, line and element as MuJoCo's compiler tells them.
    """
    return _reader(path, read).robot()


def with_keyframe(path: Path, joints: Mapping[str, float | Sequence[float]], poses: Mapping[str, Pose]) -> str:
    """The text of an MJCF file with one more keyframe, "closed": the values of its joints, and poses of links that hang on no joint."""
    reader = _reader(path)
    text = path.read_text(encoding="utf-8-sig")
    used = {e.attributes.get("name", "") for e in reader.compiled.root.walk() if e.tag == "key"}
    name = next(name for k in range(1, len(used) + 3) if (name := "closed" if k == 1 else f"closed_{k}") not in used)
    numbers = " ".join(repr(float(value) + 0.0) for value in reader.positions(joints, poses))
    before, _, after = text.rpartition("</mujoco")
    return f'{before}  <keyframe>\n    <key name="{name}" qpos="{numbers}"/>\n  </keyframe>\n</mujoco{after}'


def _reader(path: Path, read: ReadOptions = AS_IT_IS) -> Reader:
    """The compiled model, ready to be read."""
    root = read_xml(path, "mujoco")
    mujoco = _compiler()
    with _quiet(mujoco):
        try:
            spec = mujoco.MjSpec.from_file(str(path))
            meshes = _plain(mujoco, spec, root, Packages(path))
            model = spec.compile()
        except (ValueError, RuntimeError, KeyError) as error:
            raise MechanismError(f"{path}: {_sentence(str(error))}") from None
    _check_finite(path, root, model)
    compiled = CompiledModel(mujoco, model, root, path, {int(geom.id): mesh for geom, mesh in meshes})
    return Reader(compiled, motors_told=bool(read.actuated))


def _compiler() -> ModuleType:
    try:
        return import_module("mujoco")
    except ImportError:
        raise InputError(_INSTALL) from None


_ALONE = Lock()
"""Held while the compiler works: what hears its warnings is one for all threads."""


@contextmanager
def _quiet(mujoco: ModuleType) -> Iterator[None]:
    """Keep warnings of the compiler from the terminal and from the file MUJOCO_LOG.TXT."""
    with _ALONE:
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(lambda _text: None)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                yield
        finally:
            mujoco.set_mju_user_warning(before)


def _plain(mujoco: ModuleType, spec: Any, root: Element, packages: Packages) -> list[tuple[Any, Mesh]]:
    """Take out of a description what files beside it may lack and kinematics does not need; geoms with their meshes."""
    known = {mesh.name or Path(mesh.file).stem: _mesh(mesh, spec, root, packages) for mesh in spec.meshes}
    meshes: list[tuple[Any, Mesh]] = []
    for geom in spec.geoms:
        if geom.meshname in known:
            meshes.append((geom, known[geom.meshname]))
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, [1e-3] * 3
        geom.meshname = geom.hfieldname = geom.material = ""
        geom.fromto = [math.nan] * 6
    for site in spec.sites:
        site.material = ""
    for tendon in spec.tendons:
        tendon.material = ""
    unneeded = (
        spec.keys,
        spec.skins,
        spec.meshes,
        spec.hfields,
        spec.materials,
        spec.textures,
        spec.pairs,
        spec.excludes,
        spec.sensors,
    )
    for entries in unneeded:
        for entry in list(entries):
            spec.delete(entry)
    for body in spec.bodies:
        body.explicitinertial, body.mass, body.inertia = True, 1.0, [1.0] * 3
        body.ipos, body.iquat, body.fullinertia = [0.0] * 3, [1.0, 0.0, 0.0, 0.0], [math.nan] * 6
    spec.compiler.fusestatic = False
    spec.memory = spec.nstack = -1  # as large as the compiler wants them
    return meshes


def _mesh(mesh: Any, spec: Any, root: Element, packages: Packages) -> Mesh:
    """A mesh in the frame of its geom: refpos and refquat move it before its scale. Raises MechanismError for a scale of 0."""
    scale = np.array(mesh.scale, dtype=float)
    if not np.all(np.isfinite(scale)) or 0.0 in scale:
        elements = [e for e in root.walk() if e.tag == "mesh" and "scale" in e.attributes]
        guilty = next((e for e in elements if mesh.name == e.attributes.get("name")), elements[0] if elements else root)
        raise guilty.error(f"scale = {scale.tolist()} makes nothing of the mesh; numbers other than 0 are needed")
    back = Pose(np.zeros(3), np.array(mesh.refquat) / np.linalg.norm(mesh.refquat)).inverse()
    at = -scale * np.asarray(back.turn(np.array(mesh.refpos)))
    file = str(Path(spec.meshdir) / mesh.file) if mesh.file else mesh.name
    x, y, z = map(float, scale)
    return Mesh(packages.written(file), Pose(at, back.quaternion), (x, y, z))


def _sentence(message: str) -> str:
    """The compiler's message in one line."""
    text = re.sub(r"\s+", " ", message).strip()
    return re.sub(r"^(XML )?(Error: )+", "", text).replace("Element name '', id", "element").strip()


def _check_finite(path: Path, root: Element, model: Any) -> None:
    """Raises MechanismError for numbers that are none, which the compiler lets through."""
    arrays: Sequence[Any] = (
        model.body_pos, model.body_quat, model.jnt_pos, model.jnt_axis, model.qpos0, model.eq_data, model.site_pos, model.wrap_prm
    )  # fmt: skip
    if all(np.all(np.isfinite(array)) for array in arrays):
        return
    guilty = next(
        (e for e in root.walk() for v in e.attributes.values() if {"nan", "inf", "-inf"} & set(v.lower().split())), None
    )
    place = str(path) if guilty is None else guilty.where
    raise MechanismError(f"{place}: a number is not finite; allowed: numbers such as 0.25 or 1e-3")
