"""What differs between the answers of two checkouts to one case.

Modes are compared as sets, whole turns, signs of quaternions and idle coordinates aside; numbers by
tolerances that know the machine's size and the mode's condition. `condition` itself is not
compared, for it depends on where loops are cut, and words of messages are not.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from campaigns.twin_oracle import rotation

REGULAR_MODE, MULTIPLE_MODE = 1e-8, 1e-4
"""Differences of features (of the size, or rad) below which two modes are one: regular ones, and
those where solutions meet, which are known to the root of rounding."""
BY_CONDITION = 1e-12
"""What the condition of a mode adds to that, for each unit of it."""
ENTRY = 1e-7
"""Largest difference of entries of a Jacobian, of the largest entry of its row and column units."""
CLAIMS = ("certified", "has_ground", "within_limits")
COUNTS = ("count", "complex_count", "completeness", "unresolved_paths", "positive_dimensional")


@dataclass(frozen=True)
class Difference:
    """One thing that differs: what, in a sentence; the kind of question, its values on both sides,
    and all that the third method may need."""

    what: str
    kind: str
    case: Mapping[str, Any] | None
    old: Any
    new: Any
    problem: Mapping[str, Any] = field(default_factory=dict)
    mode: Mapping[str, Any] | None = None


def differences(name: str, old: Any, new: Any) -> Iterator[Difference]:
    """All differences of one machine."""
    if old is None or new is None:
        missing = "old" if old is None else "new"
        yield Difference(f"not asked in the {missing} file", "asked", None, old, new)
        return
    case = new["case"] or old["case"]
    if old["case"] != new["case"]:
        yield Difference("the questions differ", "asked", None, None, None)
        return
    if case is None:
        if old["fault"] != new["fault"]:
            yield Difference("no questions were made", "asked", None, old["fault"], new["fault"])
        return
    problems = {p["key"]: p for p in case["problems"]}
    for key in sorted({*old["answers"], *new["answers"]}):
        sides = [e["answers"].get(key, {"ended": e["fault"]}) for e in (old, new)]
        yield from _of_answer(key, case, problems.get(key, {}), *sides)


def _of_answer(
    key: str, case: Mapping[str, Any], problem: Mapping[str, Any], old: Any, new: Any
) -> Iterator[Difference]:
    states = [_state(old), _state(new)]
    if states[0] != states[1]:
        texts = [
            f"{s} ({_why(a)})" if s != "answered" else s
            for s, a in zip(states, (old, new), strict=True)
        ]
        yield Difference(f"{key}: {texts[0]} | {texts[1]}", "state", case, old, new, problem)
    elif states[0] == "answered" and "modes" in new:
        yield from _of_modes(key, case, problem, old, new)
    elif states[0] == "answered":
        for part in sorted({*old, *new}):
            if old.get(part) != new.get(part):
                what = f"{key}: {part}: {_short(old.get(part))} | {_short(new.get(part))}"
                kind = "rank" if key == "calibration" else part
                yield Difference(what, kind, case, old, new, problem)


def _state(answer: Mapping[str, Any]) -> str:
    return next((s for s in ("refused", "crashed", "ended") if s in answer), "answered")


def _why(answer: Mapping[str, Any]) -> str:
    return _short(answer[_state(answer)])


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) < 120 else text[:117] + "..."


# --- modes ----------------------------------------------------------------------------------------


def _of_modes(
    key: str, case: Mapping[str, Any], problem: Mapping[str, Any], old: Any, new: Any
) -> Iterator[Difference]:
    for part in COUNTS:
        if old[part] != new[part]:
            what = f"{key}: {part}: {old[part]} | {new[part]}"
            yield Difference(what, part, case, old, new, problem)
    pairs, only_old, only_new = matched(case, old["modes"], new["modes"])
    whole = all(len(side["modes"]) == side["count"] for side in (old, new))
    if (only_old or only_new) and whole:
        what = f"{key}: {len(only_old)} modes only in old, {len(only_new)} only in new"
        yield Difference(
            what, "modes", case, old | {"own": only_old}, new | {"own": only_new}, problem
        )
    for a, b in pairs:
        yield from _of_mode(key, case, problem, a, b)


def _of_mode(
    key: str, case: Mapping[str, Any], problem: Mapping[str, Any], a: Any, b: Any
) -> Iterator[Difference]:
    where = f"{key}: mode at {_short(a['pose'] or a['joints'])}"
    for part in CLAIMS:
        if a[part] != b[part]:
            yield Difference(
                f"{where}: {part}: {a[part]} | {b[part]}", part, case, a, b, problem, b
            )
    if "singularity" in a and "singularity" in b and a["singularity"] != b["singularity"]:
        texts = [_short(m["singularity"]) for m in (a, b)]
        yield Difference(
            f"{where}: singularity: {texts[0]} | {texts[1]}", "singularity", case, a, b, problem, b
        )
    if "jacobians" not in a or "jacobians" not in b:
        return
    for kind in sorted(a["jacobians"]):
        sides = [m["jacobians"].get(kind, {"refused": "not told"}) for m in (a, b)]
        off = entries_apart(case, *sides)
        if off is not None:
            what = f"{where}: {kind} Jacobian: {off}"
            pair = [{"entries": side} for side in sides]
            yield Difference(what, f"jacobian {kind}", case, *pair, problem, b)


def matched(
    case: Mapping[str, Any], old: list[Any], new: list[Any]
) -> tuple[list[tuple[Any, Any]], list[Any], list[Any]]:
    """Pairs of equal modes, nearest first, and those of each side that have no partner."""
    if not old or not new:
        return [], old, new
    names = set(old[0]["joints"]) & set(new[0]["joints"])
    f = [np.array([features(case, m, names) for m in side]) for side in (old, new)]
    apart = np.max(np.abs(f[0][:, None] - f[1][None]), axis=2)
    tolerance = np.maximum.outer([slack(m) for m in old], [slack(m) for m in new])
    pairs, used = [], (set[int](), set[int]())
    for flat in np.argsort(apart, axis=None, kind="stable"):
        i, j = (int(k) for k in np.unravel_index(flat, apart.shape))
        if apart[i, j] < tolerance[i, j] and i not in used[0] and j not in used[1]:
            pairs.append((old[i], new[j]))
            used[0].add(i)
            used[1].add(j)
    left = [
        [m for k, m in enumerate(s) if k not in u] for s, u in zip((old, new), used, strict=True)
    ]
    return pairs, left[0], left[1]


def slack(mode: Mapping[str, Any]) -> float:
    """How far a mode may lie from its partner."""
    condition = math.inf if mode["condition"] is None else mode["condition"]
    if mode["multiple"]:
        return MULTIPLE_MODE
    return min(REGULAR_MODE + BY_CONDITION * condition, MULTIPLE_MODE)


def features(case: Mapping[str, Any], mode: Mapping[str, Any], names: set[str]) -> np.ndarray:
    """Numbers in which equal modes are equal."""
    size, radians = case["size"], 1.0 if 'angle_unit = "rad"' in case["toml"] else math.pi / 180
    parts: list[np.ndarray] = []
    if mode["pose"] is not None:
        parts += [np.array(mode["pose"][:3]) / size, rotation(mode["pose"][3:]).ravel()]
    parts += [np.array(point) / size for _, point in sorted(mode["points"].items())]
    for name in sorted(names - set(case["idle"])):
        value, kind = mode["joints"][name], case["kinds"].get(name)
        if kind == "quaternion" or isinstance(value, list):
            parts.append(rotation(value).ravel())
        elif kind == "length":
            parts.append(np.array([value / size]))
        elif kind == "turns":
            parts.append(np.array([value * radians]))
        else:
            parts.append(np.array([math.cos(value * radians), math.sin(value * radians)]))
    return np.concatenate(parts) if parts else np.zeros(1)


def entries_apart(case: Mapping[str, Any], old: Any, new: Any) -> str | None:
    """What differs between two matrices by names; None where nothing does. Entries that relate
    lengths and angles are made plain by the size."""
    if ("refused" in old) != ("refused" in new):
        texts = [
            _short(side["refused"]) if "refused" in side else "answered" for side in (old, new)
        ]
        return f"{texts[0]} | {texts[1]}"
    if "refused" in old:
        return None
    rows, columns = (
        sorted(set(old) & set(new)),
        sorted({c for side in (old, new) for r in side.values() for c in r}),
    )
    if not rows or any(set(side[r]) != set(columns) for side in (old, new) for r in rows):
        return f"other names: {_short(sorted(old))} | {_short(sorted(new))}"
    units = np.array([_unit(case, r) for r in rows])[:, None] / np.array(
        [_unit(case, c) for c in columns]
    )
    tables = [
        np.array([[_number(side[r][c]) for c in columns] for r in rows]) / units
        for side in (old, new)
    ]
    with np.errstate(invalid="ignore"):
        off = np.abs(tables[0] - tables[1])
        scale = max(1.0, float(np.nanmax(np.abs(tables), initial=0.0)))
    off = np.where(np.isnan(tables[0]) & np.isnan(tables[1]), 0.0, np.nan_to_num(off, nan=math.inf))
    if float(np.max(off, initial=0.0)) <= ENTRY * scale:
        return None
    return f"entries differ by {np.max(off):.2g}, of {scale:.2g}"


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _unit(case: Mapping[str, Any], name: str) -> float:
    """The size for coordinates that are lengths."""
    if name in ("vx", "vy", "vz", "x", "y", "z") or case["kinds"].get(name) == "length":
        return float(case["size"])
    return 1.0
