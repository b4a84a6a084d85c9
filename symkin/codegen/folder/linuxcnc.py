"""Write a LinuxCNC kinematics component: the functions that its motion module calls, and HAL pins
of the geometry.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symkin.codegen.map.joint_map import JointMap
from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.map.program import Program
from symkin.codegen.serial_arm import SerialArm
from symkin.codegen.text.c import indent
from symkin.codegen.text.templates import fill
from symkin.errors import InputError

_LONGEST_PIN = 47
"""Characters of a HAL name (HAL_NAME_LEN)."""
_CONVERSIONS = {"spherical": "spatial", "schoenflies": "turn", "planar": "turn"}
"""How world coordinates are made of a pose, by the platform's motion where they are not those of
its name.
"""
_TURNS = {
    "spatial": "A, B, C are turns about the base's x, y, z in this order (R = Rz(C) Ry(B) Rx(A)).",
    "turn": "C is the turn from home about z; A and B are 0.",
    "translation": "A, B, C are 0.",
}
_DEGREES = 180.0 / np.pi
_MM = {"mm": 1.0, "m": 1000.0}


def linuxcnc_text(program: Program, home: np.ndarray | None) -> str:
    """NAME_kins.c, which includes NAME.c; `home` is the pose (7,) from which a platform's direct
    problem begins, None of arms. Raises InputError for a geometry whose names are too long for HAL.
    """
    name = program.mechanism.name
    unit = program.mechanism.length_unit
    mm, units = _MM[unit], [c.is_angular for c in program.mechanism.actuated]
    pins, serial = _pins(program), isinstance(program.kind, SerialArm)
    kind = program.kind
    is_turned = isinstance(kind, LimbPlatform) and kind.frames is not None
    motion = "spatial" if serial or is_turned else program.mechanism.motion
    conversion = _CONVERSIONS.get(motion, motion)
    moved = {"planar": (0, 1), "spherical": ()}.get(motion, (0, 1, 2))
    shown = program.values | {
        "mm": repr(mm),
        "joint_units": ", ".join(
            repr(float(_DEGREES)) if angular else repr(mm) for angular in units
        ),
        "units": "degrees" if all(units) else "mm" if not any(units) else "mm and degrees",
        "turns_told": _TURNS[conversion],
        "memory": "" if home is None else _memory(program, home),
        "pins": _pins_text(name, pins),
        "new_pins": _new_pins(name, pins),
        "pins_told": f"\n * HAL pins {name}_kins.* hold the geometry ({unit}, radians)."
        if pins
        else "",
        "geometry": (
            f"    const {name}_geometry now = {name}_geometry_now();\n"
            f"    const {name}_geometry *const geometry = &now;"
        )
        if pins
        else "",
        "positions": [
            f"pose.position[{i}] = world->tran.{'xyz'[i]} / {name.upper()}_MM;" for i in moved
        ],
        "from_home": [
            f"pose.position[{i}] = {name}_home.position[{i}];" for i in range(3) if i not in moved
        ],
    }
    conversions = fill(f"kins_{conversion}.c", shown).rstrip()
    return fill(
        "kins.c", shown | {"conversions": conversions + "\n"} | _calls(name, shown, serial=serial)
    )


def _calls(name: str, shown: Mapping[str, object], *, serial: bool) -> dict[str, str]:
    """Statements that ask an arm, or a platform, whose last pose is kept."""
    ga, ok = shown["ga"], f"{name.upper()}_OK"
    if serial:
        return {
            "forward": f"    status = {name}_direct({ga}joints, &pose);",
            "inverse": "0, &pose, joints, joints, 0",
            "remembered": "",
        }
    call = f"status = {name}_direct({ga}0, joints, &{name}_{{}}, &pose, 0);"
    lines = [
        "/* the line from the last pose, else the one from home */",
        call.format("last"),
        f"if (status != {ok}) {{",
        "    " + call.format("home"),
        "}",
    ]
    return {
        "forward": indent(lines),
        "inverse": "&pose, joints",
        "remembered": f"    {name}_last = pose;",
    }


def _memory(program: Program, home: np.ndarray) -> str:
    """Home, and the last pose, from which the direct problem begins."""
    name, numbers = program.mechanism.name, [program.real.literal(v) for v in home]
    pose = f"{{ {{ {', '.join(numbers[:3])} }}, {{ {', '.join(numbers[3:])} }} }}"
    return (
        f"static const {name}_pose {name}_home = {pose};\n"
        f"static {name}_pose {name}_last = {pose}; /* where the direct problem begins */"
    )


def _pins(program: Program) -> list[tuple[str, str, float]]:
    """(pin, C text of the struct's member, nominal value) of each number of the geometry, where it
    is given at run time.
    """
    kind, name = program.kind, program.mechanism.name
    if isinstance(kind, JointMap) or program.options.geometry != "struct":
        return []
    found = []
    for text, value in zip(kind.geometry.names, kind.geometry.values, strict=True):
        member = text.removeprefix("geometry->")
        pin = f"{name}_kins." + member.replace("[", ".").replace("]", "").replace("_", "-")
        if len(pin) > _LONGEST_PIN:
            raise InputError(
                f"{name}: HAL pin {pin} has {len(pin)} characters; allowed: {_LONGEST_PIN}; "
                f"shorten the names of limbs or joints"
            )
        found.append((pin, member, float(value)))
    return found


def _pins_text(name: str, pins: list[tuple[str, str, float]]) -> str:
    """The pins' memory and the function that reads them."""
    if not pins:
        return ""
    return "\n".join(
        [
            f"#define {name.upper()}_PINS ({len(pins)})",
            f"static hal_float_t **{name}_pins; /* in HAL's memory */",
            "",
            "/* The geometry as the pins hold it now. */",
            f"static {name}_geometry {name}_geometry_now(void)",
            "{",
            f"    {name}_geometry now;",
            *(f"    now.{member} = *{name}_pins[{i}];" for i, (_, member, _) in enumerate(pins)),
            "    return now;",
            "}",
            "",
        ]
    )


def _new_pins(name: str, pins: list[tuple[str, str, float]]) -> list[str]:
    """Statements that make the pins with the nominal values."""
    if not pins:
        return []
    return [
        f"static const char *const names[{len(pins)}] = {{",
        *(f'    "{pin}",' for pin, _, _ in pins),
        "};",
        f"static const double nominal[{len(pins)}] = {{",
        *(f"    {value!r}," for _, _, value in pins),
        "};",
        f"{name}_pins = hal_malloc({name.upper()}_PINS * sizeof *{name}_pins);",
        f"fault = ({name}_pins == 0) ? -1 : 0;",
        f"for (int i = 0; (i < {name.upper()}_PINS) && (fault == 0); ++i) {{",
        f'    fault = hal_pin_float_newf(HAL_IO, &{name}_pins[i], {name}_component, "%s", '
        f"names[i]);",
        "    if (fault == 0) {",
        f"        *{name}_pins[i] = nominal[i];",
        "    }",
        "}",
    ]
