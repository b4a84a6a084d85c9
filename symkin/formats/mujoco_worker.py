"""Compile an MJCF file with MuJoCo, in a child process (`formats/child.py`): its model as plain
numbers and names.

MuJoCo's own compiler resolves defaults, classes, includes, frames and angles. What files beside the
MJCF may lack and kinematics does not need is taken out before: meshes and textures by name,
inertias replaced. This file imports nothing of symkin, so that the child starts quickly.
"""

import math
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

_COUNTS = ("nbody", "njnt", "neq", "nu", "ntendon", "npair", "nflex", "nsensor")
_ARRAYS = (
    "body_parentid",
    "body_jntadr",
    "body_jntnum",
    "body_mocapid",
    "body_pos",
    "body_quat",
    "jnt_type",
    "jnt_qposadr",
    "jnt_bodyid",
    "jnt_limited",
    "jnt_range",
    "jnt_pos",
    "jnt_axis",
    "qpos0",
    "eq_obj1id",
    "eq_obj2id",
    "eq_active0",
    "eq_data",
    "site_bodyid",
    "site_pos",
    "site_quat",
    "tendon_adr",
    "tendon_num",
    "wrap_objid",
    "wrap_prm",
    "actuator_trnid",
    "actuator_gear",
    "actuator_gainprm",
    "actuator_forcelimited",
    "actuator_forcerange",
    "actuator_ctrllimited",
    "actuator_ctrlrange",
    "jnt_dofadr",
    "jnt_actfrclimited",
    "jnt_actfrcrange",
    "dof_armature",
    "geom_bodyid",
    "geom_pos",
    "geom_quat",
)
_PLACED = ("qpos", "xpos", "xquat", "xanchor", "xaxis")
_NO_NAME = (
    "Caught an unknown exception!",
    "MuJoCo's compiler failed and tells no reason; a size or a count may be too large for memory",
)
MOST_BODIES = 20_000
"""Bodies, joints or constraints of a model that are sent: a mechanism may have a thousand moving
parts.
"""


def work(task: dict[str, Any]) -> dict[str, Any]:
    """The model of the file `task["path"]`, or `error`, the compiler's words."""
    try:
        mujoco = import_module("mujoco")
    except ImportError as error:
        return {"error": f"the package mujoco cannot be imported: {error}"}
    mujoco.set_mju_user_warning(lambda _text: None)  # else they are written to MUJOCO_LOG.TXT
    try:
        spec = mujoco.MjSpec.from_file(task["path"])
        meshes, of_geoms = _plain(mujoco, spec)
        model = spec.compile()
        if max(model.nbody, model.njnt, model.neq, model.nu) > MOST_BODIES:
            return {
                "error": (
                    f"the model has more than {MOST_BODIES} bodies, joints, constraints or "
                    f"actuators"
                )
            }
        told = _told(mujoco, model)
    except UnicodeDecodeError as error:
        return {"error": f"the name {error.object!r} is not UTF-8; write the file in UTF-8"}
    except (ValueError, RuntimeError, KeyError, mujoco.FatalError) as error:
        return {"error": str(error).replace(*_NO_NAME)}
    shown = [(int(geom.id), mesh) for geom, mesh in of_geoms]
    return told | {"meshes": meshes, "mesh_of_geom": shown}


def _plain(mujoco: Any, spec: Any) -> tuple[list[dict[str, Any]], list[tuple[Any, str]]]:
    """Take out of a description what kinematics does not need; its meshes, and geoms with the names
    of theirs.
    """
    meshes = [
        {
            "name": mesh.name or Path(mesh.file).stem,
            "named": bool(mesh.name),
            "file": str(Path(spec.meshdir) / mesh.file) if mesh.file else mesh.name,
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
    for entries in (
        spec.keys,
        spec.skins,
        spec.meshes,
        spec.hfields,
        spec.materials,
        spec.textures,
        spec.pairs,
        spec.excludes,
        spec.sensors,
    ):
        for entry in list(entries):
            spec.delete(entry)
    for body in spec.bodies:
        body.explicitinertial, body.mass, body.inertia = True, 1.0, [1.0] * 3
        body.ipos, body.iquat, body.fullinertia = [0.0] * 3, [1.0, 0.0, 0.0, 0.0], [math.nan] * 6
    spec.compiler.fusestatic = False
    spec.memory = spec.nstack = -1  # as large as the compiler wants them
    return meshes, of_geoms


def _armature(model: Any) -> list[float]:
    """The armature of each actuator, which older versions know of joints alone."""
    told = getattr(model, "actuator_armature", None)
    return [0.0] * model.nu if told is None else np.asarray(told).tolist()


def _told(mujoco: Any, model: Any) -> dict[str, Any]:
    """Numbers, kinds and names of a compiled model, and its bodies where joints that one equality
    holds stand at their values.
    """
    kinds = {
        "joint": _words(mujoco.mjtJoint, model.jnt_type),
        "equality": _words(mujoco.mjtEq, model.eq_type),
        "actuator": _words(mujoco.mjtTrn, model.actuator_trntype),
        "gain": _words(mujoco.mjtGain, model.actuator_gaintype),
        "bias": _words(mujoco.mjtBias, model.actuator_biastype),
        "wrap": _words(mujoco.mjtWrap, model.wrap_type),
    }
    objects = mujoco.mjtObj
    names = {
        word: [mujoco.mj_id2name(model, kind, k) or "" for k in range(count)]
        for word, kind, count in (
            ("body", objects.mjOBJ_BODY, model.nbody),
            ("joint", objects.mjOBJ_JOINT, model.njnt),
            ("equality", objects.mjOBJ_EQUALITY, model.neq),
            ("actuator", objects.mjOBJ_ACTUATOR, model.nu),
            ("tendon", objects.mjOBJ_TENDON, model.ntendon),
            ("flex", objects.mjOBJ_FLEX, model.nflex),
        )
    }
    data = mujoco.MjData(model)
    for k, kind in enumerate(kinds["equality"]):
        if kind == "joint" and model.eq_active0[k] and model.eq_obj2id[k] < 0:
            place = model.jnt_qposadr[model.eq_obj1id[k]]
            data.qpos[place] = model.qpos0[place] + model.eq_data[k][0]
    mujoco.mj_kinematics(model, data)
    sites = int(objects.mjOBJ_SITE)
    return {
        "numbers": {key: int(getattr(model, key)) for key in _COUNTS},
        "arrays": {key: np.asarray(getattr(model, key)).tolist() for key in _ARRAYS}
        | {"actuator_armature": _armature(model)},
        "placed": {key: np.asarray(getattr(data, key)).tolist() for key in _PLACED},
        "kinds": kinds,
        "names": names,
        "by_sites": [int(kind) == sites for kind in model.eq_objtype],
        "name": bytes(model.names).split(b"\0", 1)[0].decode("utf-8", "replace"),
        "texts": _texts(model),
    }


def _words(enumeration: Any, values: Any) -> list[str]:
    """The names of an enumeration's values, without what all of them begin with: hinge for
    mjJNT_HINGE.
    """
    return [str(enumeration(int(value)).name).split("_", 1)[1].lower() for value in values]


def _texts(model: Any) -> dict[str, str]:
    """Custom texts by their names."""
    found: dict[str, str] = {}
    names, data = bytes(model.names), bytes(model.text_data)
    for place, first, size in zip(model.name_textadr, model.text_adr, model.text_size, strict=True):
        name = names[int(place) :].split(b"\0", 1)[0].decode("utf-8", "replace")
        found.setdefault(
            name, data[int(first) : int(first) + int(size)].rstrip(b"\0").decode("utf-8", "replace")
        )
    return found
