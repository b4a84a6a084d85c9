"""Write calls.h of a folder of generated C: tables of its vectors, and a call of each function that
its header declares, for inputs.h.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

from asked import BENCH

_VALUES = ("JOINTS", "GUESS", "POSE", "FOUND", "FOUND_GUESS", "TO")
"""Slots of inputs.h that vectors have."""
_GIVEN = {"joints": "JOINTS", "found": "FOUND", "pose": "POSE", "from": "POSE", "to": "TO"}
_GIVEN |= {"twist": "TWIST", "rates": "RATES", "joint_rates": "RATES"}
_GIVEN |= {"joint_limits": "LIMITS", "joint_inertias": "LIMITS", "rate_limits": "LIMITS"}
_GIVEN |= {"found_rates": "FOUND_RATES", "found_torques": "FOUND_RATES"}
"""Slots of what functions are given, by its name."""
_BEGINS = {"joints": "GUESS", "found": "FOUND_GUESS", "pose": "POSE"}
"""Slots in which results begin, which functions that move read."""


def driver(folder: Path, what: str, place: Path) -> str:
    """Write calls.h into a place; the words of a compiler's command for drive.c as `what`: FUZZ,
    WORST or COUNTS.
    """
    (place / "calls.h").write_text(calls_text(folder))
    return f"-D{what} -I{place} -I{folder} -I{BENCH} {BENCH / 'drive.c'}"


def calls_text(folder: Path) -> str:
    """calls.h of a folder."""
    manifest = json.loads((folder / "manifest.json").read_text())
    name, struct = manifest["mechanism"], manifest["options"]["geometry"] == "struct"
    header = (folder / f"{name}.h").read_text()
    upper = name.upper()
    declared = re.findall(rf"^(?:int|{name}_status) {name}_(\w+)\(([^;]*)\);", header, re.M)
    is_arm = any(function == "inverse" and "guess" in text for function, text in declared)
    found = f"{upper}_FOUND" if "given" in manifest["options"] else "0"
    tables = dict.fromkeys(_VALUES, "NULL") | {"JOINTS": "joints", "GUESS": "joints"}
    tables |= {"FOUND": "found", "FOUND_GUESS": "found"} if found != "0" else {}
    tables |= {"POSE": "poses", "TO": "poses"} if found == "0" else {}
    tables |= {"GUESS": "guesses"} if is_arm and found == "0" else {}
    vectors = (t if t == "NULL" else f"&{name}_vector_{t}[0][0]" for t in tables.values())
    lines = [
        f'#include "{name}.h"\n#include "{name}_vectors.h"',
        f"typedef {name}_real real;\ntypedef {name}_config config;",
        f"#define N {upper}_JOINTS\n#define FOUND_COUNT {found}",
        f"#define POSES {7 * (found == '0')}",
        *(f"#define {m} {upper}_{m}" for m in ("SIZE", "TOLERANCE", "MAX_STEPS", "MAX_STEP")),
        f"#define VECTORS {upper}_VECTORS\n#define INFO {name}_info",
        f"static const real *const vectors[] = {{ {', '.join(vectors)} }};",
        f"static const {name}_geometry nominal = {upper}_NOMINAL;" if struct else "",
        "#define CALLS \\",
        *(f"    {_call(name, *one)} \\" for one in declared),
    ]
    return "\n".join(lines) + "\n\n"


def _call(name: str, function: str, parameters: str) -> str:
    """Statements that call one function, results in arrays of the largest size."""
    arguments, begins, finite = list[str](), list[str](), ["1"]
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
    call = f"{name}_{function}({', '.join(arguments)})"
    status = (
        f"(int){call}" if function != "inverse_all" else f"listed({call}, {name.upper()}_BRANCHES)"
    )
    return (
        f'{" ".join(begins)} begin(); status = {status}; finish(); end(function++, "{function}", '
        f"status, status != 0 || ({' && '.join(finite)}), number);"
    )
