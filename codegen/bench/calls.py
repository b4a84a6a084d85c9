"""Write calls.h of a folder of generated C: tables of its vectors, and a call of each function that
its header declares, for inputs.h; build drive.c with it.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from asked import BENCH

_SLOTS = ("JOINTS", "GUESS", "POSE", "FOUND", "FOUND_GUESS", "TO")
"""Slots of inputs.h that vectors have."""
_TABLES = {
    "platform": ({"GUESS": "joints", "POSE": "poses", "TO": "poses"}, {"POSE": "guesses"}),
    "arm": ({"GUESS": "guesses", "POSE": "poses", "TO": "poses"}, {}),
    "map": (
        {"GUESS": "joints", "FOUND": "found", "FOUND_GUESS": "found"},
        {"GUESS": "joint_guesses", "FOUND_GUESS": "guesses"},
    ),
}
"""Of each kind of folder the vectors of slots, and where the cases of its own test start."""
_ANSWERS = {"platform": {"POSE": "poses"}, "arm": {"JOINTS": "inverse"}}
_ANSWERS |= {"map": {"JOINTS": "inverse", "FOUND": "found"}}
_GIVEN = {"joints": "JOINTS", "found": "FOUND", "pose": "POSE", "from": "POSE", "to": "TO"}
_GIVEN |= {"twist": "TWIST", "rates": "RATES", "joint_rates": "RATES"}
_GIVEN |= {"joint_limits": "LIMITS", "joint_inertias": "LIMITS", "rate_limits": "LIMITS"}
_GIVEN |= {"found_rates": "FOUND_RATES", "found_torques": "FOUND_RATES"}
"""Slots of what functions are given, by its name."""
_BEGINS = {"joints": "GUESS", "found": "FOUND_GUESS", "pose": "POSE"}
"""Slots in which results begin, which functions that move read."""


def manifest_of(folder: Path) -> tuple[str, str, dict[str, Any]]:
    """Name, kind (platform, arm or map) and manifest of a folder."""
    manifest = json.loads((folder / "manifest.json").read_text())
    name = manifest["mechanism"]
    kind = "map" if "given" in manifest["options"] else "platform"
    if re.search(rf" {name}_inverse\([^;]*guess", (folder / f"{name}.h").read_text()):
        kind = "map" if kind == "map" else "arm"
    return name, kind, manifest


def driver(folder: Path, what: str, place: Path) -> str:
    """Write calls.h into a place; the words of a compiler's command for drive.c as `what`: FUZZ,
    CASES, WORST or COUNTS. Vectors that stand in the place go before those of the folder.
    """
    (place / "calls.h").write_text(calls_text(folder))
    return f"-D{what} -I{place} -I{folder} -I{BENCH} {BENCH / 'drive.c'}"


def calls_text(folder: Path) -> str:
    """calls.h of a folder."""
    name, kind, manifest = manifest_of(folder)
    upper, is_map, struct = name.upper(), kind == "map", manifest["options"]["geometry"] == "struct"
    header = (folder / f"{name}.h").read_text()
    declared = re.findall(rf"^(?:int|{name}_status) {name}_(\w+)\(([^;]*)\);", header, re.M)
    of_slots, starts = _TABLES[kind]
    cases = {"starts": starts, "answers": _ANSWERS[kind]}
    lines = [
        f'#include "{name}.h"\n#include "{name}_vectors.h"',
        f"typedef {name}_real real;\ntypedef {name}_config config;",
        f"#define N {upper}_JOINTS\n#define FOUND_COUNT {f'{upper}_FOUND' if is_map else 0}",
        f"#define POSES {7 * (not is_map)}",
        *(f"#define {m} {upper}_{m}" for m in ("SIZE", "TOLERANCE", "MAX_STEPS", "MAX_STEP")),
        f"#define VECTORS {upper}_VECTORS\n#define INFO {name}_info",
        _table(name, "vectors", {"JOINTS": "joints"} | of_slots),
        f"static const {name}_geometry nominal = {upper}_NOMINAL;" if struct else "",
        "#ifdef CASES",
        *(_table(name, what, tables) for what, tables in cases.items()),
        "#endif\n#define CALLS \\",
        *(f"    {_call(name, *one)} \\" for one in declared),
    ]
    return "\n".join(lines) + "\n\n"


def _table(name: str, what: str, tables: dict[str, str]) -> str:
    """Addresses of vectors by the slots of inputs.h."""
    told = (tables.get(slot) for slot in _SLOTS)
    values = (f"&{name}_vector_{t}[0][0]" if t else "NULL" for t in told)
    return f"static const real *const {what}[10] = {{ {', '.join(values)} }};"


def _call(name: str, function: str, parameters: str) -> str:
    """Statements that call one function, results in arrays of the largest size."""
    arguments, begins, finite, off = list[str](), list[str](), ["1"], "-1"
    for parameter in re.sub(r"\s+", " ", parameters).split(", "):
        found = re.fullmatch(rf"(const )?(?:{name}_)?([\w ]+) (\*?)(\w+)(.*)", parameter)
        assert found is not None, parameter  # noqa: S101 - a declaration that was generated
        const, kind, _, argument, size = found.groups()
        result = f"result[{len(begins)}]"
        if argument in ("config", "info", "geometry"):
            told = {"config": "settings", "info": "&info", "geometry": "&nominal"}[argument]
        elif kind == "unsigned int":
            told = f"(unsigned int)(number % ({name.upper()}_BRANCHES + 1))"
        elif const:
            slot = _GIVEN.get(argument, "GUESS" if size and "FOUND" not in size else "POSE")
            slot = "FOUND_GUESS" if argument == "guess" and "FOUND" in size else slot
            told = f"in->v[{slot}]"
        else:
            count = re.sub(r"\]\[", ") * (", size).strip("[]") or ("7" if kind == "pose" else "1")
            begin = f"in->v[{_BEGINS[argument]}]" if argument in _BEGINS else "NULL"
            off = _GIVEN[argument] if argument in _BEGINS else off
            begins.append(f"begun({result}, {begin}, ({count}));")
            finite.append(f"all_finite({result}, ({count}))")
            finite += [f"({result}[0] >= 0 && {result}[0] <= 1)"] if argument == "feed" else []
            told = result
        as_pose = f"({const or ''}{name}_pose *)" if kind == "pose" else ""
        rows = f"(real (*)[{name.upper()}_JOINTS])" if "][" in size else ""
        arguments.append(f"{as_pose}{rows}{told}")
    if "&info" in arguments:
        finite.append("isfinite(info.residual)")
        begins.append("info.residual = 0;")
    call, is_list = f"{name}_{function}({', '.join(arguments)})", function == "inverse_all"
    counted = f"count = {call}" if is_list else f"status = (int){call}"
    listed = f"status = listed(count, {name.upper()}_BRANCHES);" if is_list else ""
    return (
        f'if (WANTED("{function}")) {{ int count = 1; {" ".join(begins)} begin(); {counted}; '
        f'finish(); {listed} end(function, "{function}", status, '
        f"status != 0 || ({' && '.join(finite)}), number, off(result[0], {off}, number, count)); "
        "} ++function;"
    )
