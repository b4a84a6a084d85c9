"""Compile an MJCF file with MuJoCo, in a child process (`formats/child.py`): its model as plain
numbers and names.

MuJoCo's own compiler resolves defaults, classes, includes, frames and angles. What files beside the
MJCF may lack and kinematics does not need is taken out before: meshes and textures by name,
inertias replaced. This file imports nothing of symkin, so that the child starts quickly.
"""

import math
import os
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

_FINITE = (
    "body_pos",
    "body_quat",
    "jnt_pos",
    "jnt_axis",
    "qpos0",
    "eq_data",
    "site_pos",
    "wrap_prm",
)
"""Arrays of a model whose numbers move links."""
_NOT_MOVING = (
    "keys",
    "skins",
    "meshes",
    "hfields",
    "materials",
    "textures",
    "pairs",
    "excludes",
    "sensors",
)
"""Lists of a description whose entries move no link."""
_STILL = [1.0, 0.0, 0.0, 0.0]
_NO_NAME = (
    "Caught an unknown exception!",
    "MuJoCo's compiler failed and tells no reason; a size or a count may be too large for memory",
)
MOST_BODIES = 20_000
"""Bodies, joints or constraints of a model that are sent: a mechanism may have a thousand moving
parts.
"""


def _spec(mujoco: Any, path: Path) -> Any:
    """The file as the library reads it, which tells formats by suffixes in small letters."""
    if path.suffix == ".xml":
        return mujoco.MjSpec.from_file(str(path.absolute()))
    text = path.read_text("utf-8", errors="replace")
    os.chdir(path.parent)
    return mujoco.MjSpec.from_string(text)


def work(task: dict[str, Any]) -> dict[str, Any]:
    """The model of the file `task["path"]`, or `error`, the compiler's words."""
    try:
        mujoco = import_module("mujoco")
    except ImportError as error:
        return {"error": f"the package mujoco cannot be imported: {error}"}
    mujoco.set_mju_user_warning(lambda _text: None)  # else they are written to MUJOCO_LOG.TXT
    try:
        spec = _spec(mujoco, Path(task["path"]))
        idle = {
            "contact pair": len(spec.pairs),
            "flex": len(spec.flexes),
            "sensor": len(spec.sensors),
        }
        meshes, of_geoms = _plain(mujoco, spec)
        model = spec.compile()
        if max(model.nbody, model.njnt, model.neq, model.nu) > MOST_BODIES:
            what = f"{MOST_BODIES} bodies, joints, constraints or actuators"
            return {"error": f"the model has more than {what}"}
        told = _Told(mujoco, model).all()
    except UnicodeDecodeError as error:
        return {"error": f"the name {error.object!r} is not UTF-8; write the file in UTF-8"}
    except (ValueError, RuntimeError, KeyError, mujoco.FatalError) as error:
        return {"error": str(error).replace(*_NO_NAME)}
    shown = [
        {
            "mesh": mesh,
            "body": int(model.geom_bodyid[geom.id]),
            "position": model.geom_pos[geom.id].tolist(),
            "quaternion": model.geom_quat[geom.id].tolist(),
        }
        for geom, mesh in of_geoms
    ]
    return told | {"meshes": meshes, "shown": shown, "idle": idle}


def _plain(mujoco: Any, spec: Any) -> tuple[list[dict[str, Any]], list[tuple[Any, str]]]:
    """Take out of a description what kinematics does not need; its meshes, and geoms with the names
    of theirs.
    """
    meshes = [
        {
            "name": mesh.name or Path(mesh.file).stem,
            "named": bool(mesh.name),
            "file": _place(spec, mesh.file) if mesh.file else mesh.name,
            **{
                key: [float(x) for x in getattr(mesh, key)]
                for key in ("scale", "refpos", "refquat")
            },
        }
        for mesh in spec.meshes
    ]
    known = {mesh["name"] for mesh in meshes}
    of_geoms = []
    for geom in spec.geoms:
        if geom.meshname in known:
            of_geoms.append((geom, geom.meshname))
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, [1e-3] * 3
        geom.meshname = geom.hfieldname = geom.material = ""
        geom.fromto = [math.nan] * 6
    for shown in (*spec.sites, *spec.tendons):
        shown.material = ""
    for kind in _NOT_MOVING:
        for entry in list(getattr(spec, kind)):
            spec.delete(entry)
    for body in spec.bodies:
        body.explicitinertial, body.mass, body.inertia = True, 1.0, [1.0] * 3
        body.ipos, body.iquat, body.fullinertia = [0.0] * 3, [1.0, 0.0, 0.0, 0.0], [math.nan] * 6
    spec.compiler.fusestatic = False
    spec.memory = spec.nstack = spec.njmax = spec.nconmax = -1  # as large as the compiler wants
    return meshes, of_geoms


def _place(spec: Any, file: str) -> str:
    """A mesh's file as the folder of the model's file has it. One that an included file names and
    the meshes' folder lacks is told as beside the included file, from the root.
    """
    path, home = Path(spec.meshdir) / file, Path(spec.modelfiledir)
    return str(path.relative_to(home) if path.is_relative_to(home) else path)


class _Told:
    """Records of a compiled model by their numbers in it, bodies and joints where joints that one
    equality holds stand at their values.
    """

    def __init__(self, mujoco: Any, model: Any) -> None:
        self.mujoco, self.model, self.data = mujoco, model, mujoco.MjData(model)
        for k in range(model.neq):
            equality = self.equality(k)
            joint, other = equality["objects"]
            if equality["kind"] == "joint" and equality["active"] and other < 0:
                place = model.jnt_qposadr[joint]
                self.data.qpos[place] = model.qpos0[place] + model.eq_data[k][0]
        mujoco.mj_kinematics(model, self.data)

    def all(self) -> dict[str, Any]:
        model = self.model
        return {
            "bodies": [self.body(k) for k in range(model.nbody)],
            "joints": [self.joint(k) for k in range(model.njnt)],
            "equalities": [self.equality(k) for k in range(model.neq)],
            "tendons": [self.tendon(k) for k in range(model.ntendon)],
            "actuators": [self.actuator(k) for k in range(model.nu)],
            "qpos": self.data.qpos.tolist(),
            "finite": all(bool(np.all(np.isfinite(getattr(model, key)))) for key in _FINITE),
            "name": _text(bytes(model.names)),
            "texts": _texts(model),
        }

    def name(self, kind: str, number: int) -> str:
        objects = getattr(self.mujoco.mjtObj, f"mjOBJ_{kind}")
        return self.mujoco.mj_id2name(self.model, objects, number) or ""

    def word(self, enumeration: str, value: Any) -> str:
        """The name of an enumeration's value, without what all of them begin with: hinge for
        mjJNT_HINGE.
        """
        kinds = getattr(self.mujoco, enumeration)
        return str(kinds(int(value)).name).split("_", 1)[1].lower()

    def body(self, k: int) -> dict[str, Any]:
        model, data = self.model, self.data
        first, count = int(model.body_jntadr[k]), int(model.body_jntnum[k])
        return {
            "name": self.name("BODY", k) or f"body{k}",
            "parent": int(model.body_parentid[k]),
            "joints": list(range(first, first + count)),
            "mocap": int(model.body_mocapid[k]) >= 0,
            "position": data.xpos[k].tolist(),
            "quaternion": data.xquat[k].tolist(),
        }

    def joint(self, k: int) -> dict[str, Any]:
        """Values are those at the file's own configuration (`zero`) and where it stands."""
        model, data, place = self.model, self.data, int(self.model.jnt_qposadr[k])
        limited = model.jnt_actfrclimited[k]
        return {
            "name": self.name("JOINT", k),
            "kind": self.word("mjtJoint", model.jnt_type[k]),
            "body": int(model.jnt_bodyid[k]),
            "place": place,
            "range": model.jnt_range[k].tolist() if model.jnt_limited[k] else None,
            "anchor": data.xanchor[k].tolist(),
            "axis": data.xaxis[k].tolist(),
            "zero": float(model.qpos0[place]),
            "value": float(data.qpos[place]),
            "armature": float(model.dof_armature[model.jnt_dofadr[k]]),
            "force": model.jnt_actfrcrange[k].tolist() if limited else [-math.inf, math.inf],
        }

    def equality(self, k: int) -> dict[str, Any]:
        """Connects and welds have two bodies, and the frames on them that are one."""
        model, kind = self.model, self.word("mjtEq", self.model.eq_type[k])
        numbers, ends = model.eq_data[k], [int(model.eq_obj1id[k]), int(model.eq_obj2id[k])]
        found = {
            "name": self.name("EQUALITY", k),
            "kind": kind,
            "active": bool(model.eq_active0[k]),
            "objects": ends,
            "coefficients": numbers[:5].tolist(),
            "flex": self.name("FLEX", ends[0]) if kind.startswith("flex") else "",
            "closes": kind in ("connect", "weld"),
            "rigid": kind == "weld" and bool(numbers[10] != 0.0),
        }
        if not found["closes"]:
            return found
        if int(model.eq_objtype[k]) == int(self.mujoco.mjtObj.mjOBJ_SITE):
            found["bodies"] = model.site_bodyid[ends].tolist()
            found["frames"] = [
                [model.site_pos[e].tolist(), model.site_quat[e].tolist()] for e in ends
            ]
            return found
        first, second = numbers[:3].tolist(), numbers[3:6].tolist()
        found["bodies"] = [max(end, 0) for end in ends]
        found["frames"] = [[first, _STILL], [second, _STILL]]
        if kind == "weld":  # its anchor is on the second body
            turn = numbers[6:10] / np.linalg.norm(numbers[6:10])
            found["frames"] = [[second, turn.tolist()], [first, _STILL]]
        return found

    def tendon(self, k: int) -> dict[str, Any]:
        """Joints and factors of a fixed tendon; none of a spatial one."""
        model = self.model
        wraps = range(model.tendon_adr[k], model.tendon_adr[k] + model.tendon_num[k])
        fixed = all(self.word("mjtWrap", model.wrap_type[w]) == "joint" for w in wraps)
        joints = [(int(model.wrap_objid[w]), float(model.wrap_prm[w])) for w in wraps]
        return {"name": self.name("TENDON", k), "joints": joints if fixed else None}

    def actuator(self, k: int) -> dict[str, Any]:
        """The hinges and slides that it drives, directly or through a fixed tendon; its force is
        within its own range, and within that of its control where it is a multiple of it.
        """
        model, kind = self.model, self.word("mjtTrn", self.model.actuator_trntype[k])
        target, direct = int(model.actuator_trnid[k][0]), kind in ("joint", "jointinparent")
        joints = [target] if direct else []
        if kind == "tendon":
            joints = [joint for joint, _ in self.tendon(target)["joints"] or ()]
        low, high = -math.inf, math.inf
        if model.actuator_forcelimited[k]:
            low, high = map(float, model.actuator_forcerange[k])
        gain = self.word("mjtGain", model.actuator_gaintype[k])
        bias = self.word("mjtBias", model.actuator_biastype[k])
        if (gain, bias) == ("fixed", "none") and model.actuator_ctrllimited[k]:
            factor = float(model.actuator_gainprm[k][0])
            first, last = sorted(factor * float(c) for c in model.actuator_ctrlrange[k])
            low, high = max(low, first), min(high, last)
        armatures = getattr(model, "actuator_armature", None)  # of joints alone before
        return {
            "name": self.name("ACTUATOR", k),
            "joints": [
                j for j in joints if self.word("mjtJoint", model.jnt_type[j]) in ("hinge", "slide")
            ],
            "direct": direct,
            "gear": float(model.actuator_gear[k][0]),
            "armature": 0.0 if armatures is None else float(armatures[k]),
            "force": [low, high],
        }


def _text(content: bytes) -> str:
    """A text up to its end."""
    return content.split(b"\0", 1)[0].decode("utf-8", "replace")


def _texts(model: Any) -> dict[str, str]:
    """Custom texts by their names."""
    found: dict[str, str] = {}
    names, data = bytes(model.names), bytes(model.text_data)
    for place, first, size in zip(model.name_textadr, model.text_adr, model.text_size, strict=True):
        value = data[int(first) : int(first) + int(size)].rstrip(b"\0").decode("utf-8", "replace")
        found.setdefault(_text(names[int(place) :]), value)
    return found
