"""Write calls.h of a folder of generated C: tables of its vectors, and a call of each function of
its interface, for drive.c.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from processors import BENCH, linked
from symkin.codegen.map import signature
from symkin.codegen.map.signature import Function, Value

_ALL = Function("inverse_all", "pose -> joints")
_FUNCTIONS = {
    "platform": (*signature.PLATFORM, signature.LINE, *signature.PLATFORM_SPEEDS),
    "arm": (*signature.ARM, *signature.CLOSED_ARM, *signature.ARM_SPEEDS),
    "map": signature.MAP,
}
_SLOTS = ("JOINTS", "GUESS", "POSE", "FOUND", "FOUND_GUESS", "TO")
"""Slots of drive.c that vectors have."""
_TABLES = {
    "platform": (
        {"JOINTS": "joints", "GUESS": "joints", "POSE": "poses", "TO": "poses"},
        {"POSE": "guesses"},
        {"POSE": "poses"},
    ),
    "arm": (
        {"JOINTS": "joints", "GUESS": "guesses", "POSE": "poses", "TO": "poses"},
        {},
        {"JOINTS": "inverse"},
    ),
    "map": (
        {"JOINTS": "joints", "GUESS": "joints", "FOUND": "found", "FOUND_GUESS": "found"},
        {"GUESS": "joint_guesses", "FOUND_GUESS": "guesses"},
        {"JOINTS": "inverse", "FOUND": "found"},
    ),
}
"""Of each kind of folder the vectors of slots, where the cases of its own test start, and its
answers.
"""
_READ = {"from": "POSE", "joint_rates": "RATES", "found_torques": "FOUND_RATES"}
_READ |= dict.fromkeys(("joint_limits", "joint_inertias", "rate_limits"), "LIMITS")
_READ |= {"guess": "POSE", "guess NAME_JOINTS": "GUESS", "guess NAME_FOUND": "FOUND_GUESS"}
"""Slots of arguments that are not those of their names."""
_BEGINS = {"joints": "GUESS", "found": "FOUND_GUESS", "pose": "POSE"}
"""Slots in which results begin, which functions that move read."""


def manifest_of(folder: Path) -> tuple[str, str, dict[str, Any]]:
    """Name, kind (platform, arm or map) and manifest of a folder."""
    manifest = json.loads((folder / "manifest.json").read_text())
    name, is_map = manifest["mechanism"], "given" in manifest["options"]
    header = (folder / f"{name}.h").read_text()
    is_arm = re.search(rf" {name}_inverse\([^;]*guess", header) is not None
    return name, "map" if is_map else "arm" if is_arm else "platform", manifest


def program(
    folder: Path,
    hooks: str | Path,
    processor: str,
    place: Path,
    words: str = "",
    cc: str = "gcc",
) -> Path:
    """drive.c with these hooks and a folder's code, built in a place. Vectors that stand in the
    place go before those of the folder.
    """
    source = folder / f"{manifest_of(folder)[0]}.c"
    return linked(processor, f"{words} {driver(folder, hooks, place)} {source}", place, cc)


def driver(folder: Path, hooks: str | Path, place: Path) -> str:
    """Write calls.h into a place; the words of a compiler's command for drive.c with hooks."""
    (place / "calls.h").write_text(calls_text(folder))
    return f"""-D'HOOKS="{hooks}"' -I{place} -I{folder} -I{BENCH} {BENCH / "drive.c"}"""


def calls_text(folder: Path) -> str:
    """calls.h of a folder."""
    name, kind, manifest = manifest_of(folder)
    is_map, struct = kind == "map", manifest["options"]["geometry"] == "struct"
    header = (folder / f"{name}.h").read_text()
    declared = re.findall(rf"^(?:int|{name}_status) {name}_(\w+)\(", header, re.M)
    known = {function.name: function for function in (_ALL, *_FUNCTIONS[kind])}
    numbers = ("JOINTS", "SIZE", "TOLERANCE", "MAX_STEPS", "MAX_STEP", "VECTORS")
    lines = [
        '#include "name.h"\n#include "name_vectors.h"',
        "typedef name_real real;\ntypedef name_config config;",
        "#define N NAME_JOINTS\n#define INFO name_info",
        f"#define FOUND_COUNT {'NAME_FOUND' if is_map else 0}\n#define POSES {7 * (not is_map)}",
        *(f"#define {m} NAME_{m}" for m in numbers[1:]),
        *map(_table, ("vectors", "starts", "answers"), _TABLES[kind]),
        "static const name_geometry nominal = NAME_NOMINAL;" if struct else "",
        "#define CALLS \\",
        *(f"    {_call(known[function], struct=struct)} \\" for function in declared),
    ]
    text = "\n".join(lines) + "\n\n"
    return re.sub(r"\bNAME_", f"{name.upper()}_", re.sub(r"\bname(?=[_.])", name, text))


def _table(what: str, tables: dict[str, str]) -> str:
    """Addresses of vectors by the slots of drive.c."""
    told = (tables.get(slot) for slot in _SLOTS)
    values = (f"&name_vector_{t}[0][0]" if t else "NULL" for t in told)
    return f"static const real *const {what}[10] = {{ {', '.join(values)} }};"


def _call(function: Function, *, struct: bool) -> str:
    """Statements that call one function, results in arrays of the largest size."""
    is_list, name = function is _ALL, function.name
    begins, finite, answer = list[str](), list[str](), "-1"
    arguments = [*(["&nominal"] if struct else []), *(["settings"] if function.config else [])]
    arguments += [_argument(f"in->v[{_slot(value)}]", value, "const ") for value in function.takes]
    for k, value in enumerate(function.gives):
        count = value.count or "7"
        arguments.append(_argument(f"result[{k}]", value))
        if is_list:
            count, arguments[-1] = f"NAME_BRANCHES * {count}", "(real (*)[N])result[0]"
        begin = _BEGINS.get(value.name)
        begins.append(f"begun(result[{k}], {f'in->v[{begin}]' if begin else 'NULL'}, {count});")
        finite.append(f"all_finite(result[{k}], {count})")
        answer = value.name.upper() if begin else answer
    finite += ["result[0][0] >= 0 && result[0][0] <= 1"] if name == "feed" else []
    if function.info:
        arguments.append("&info")
        begins.append("info.residual = 0;")
        finite.append("isfinite(info.residual)")
    read = [
        *map(_slot, function.takes),
        *(_BEGINS[v.name] for v in function.gives if function.moves),
    ]
    mask = " | ".join(f"1 << {slot}" for slot in read if slot != "BRANCH")
    begins.append(f"reads = {mask};")
    called = f"{'count =' if is_list else 'status = (int)'} name_{name}({', '.join(arguments)});"
    listed = "status = (count < 0 || count > NAME_BRANCHES) ? -1 : (count == 0);" if is_list else ""
    return (
        f'if (WANTED("{name}")) {{ int count = 1; {" ".join(begins)} begin(); {called} finish(); '
        f'{listed} names[function] = "{name}"; end(function, status, status != 0 || '
        f"({' && '.join(finite)}), number, off(result[0], {answer}, number, count)); }} ++function;"
    )


def _slot(value: Value) -> str:
    """The slot that an argument is read from."""
    named = _READ.get(value.name, value.name.upper())
    return _READ.get(f"{value.name} {value.count}", named)


def _argument(array: str, value: Value, const: str = "") -> str:
    """An array as the type of an argument."""
    if value.name == "branch":
        return "(unsigned int)(number % (NAME_BRANCHES + 1))"
    return array if value.count else f"({const}name_pose *){array}"
