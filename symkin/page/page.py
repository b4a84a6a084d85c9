"""The page of a mechanism: one HTML text that holds everything, so that it needs no network and no
server.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.page.model_data import page_model
from symkin.page.plane import painted_plane
from symkin.page.scene import scene_of
from symkin.page.static_files import static_template, static_text
from symkin.position.determination import Determination, determination
from symkin.position.problem import build_problem
from symkin.position.solve import solve
from symkin.text import first_of

_MODULES = {
    "three": "vendor/three.module.min.js",
    "OrbitControls": "vendor/OrbitControls.js",
    **{
        f"symkin/{name}": f"{name}.js"
        for name in ("look", "shapes", "items", "drawing", "inputs", "labels", "strip")
    },
    **{f"symkin/{name}": f"{name}.js" for name in ("drag", "plane", "player", "trace", "page")},
}
"""Files of the page's modules by the names under which they import each other."""
_TURN = {"deg": 180.0, "rad": math.pi}


@dataclass(frozen=True)
class PlayedPath:
    """Rows of values of the given coordinates `names` that the page plays, at `times` (s) where
    there are any, in the mode of `start` (as `Solution.to_dict` tells it) where it is known.
    """

    title: str
    names: Sequence[str]
    rows: Sequence[Sequence[float]]
    times: Sequence[float] | None = None
    start: Mapping[str, Any] | None = None


def page_html(
    mechanism: Mechanism,
    given: Mapping[str, float] | None = None,
    path: PlayedPath | None = None,
    start: Mapping[str, Any] | None = None,
    plane: Mapping[str, Any] | None = None,
) -> str:
    """The page of a mechanism as HTML text.

    `given` are the coordinates with sliders and their values at the start, in the mechanism's units
    (None: the actuated joints at the example or the reference, or as `completed_sliders` has them);
    `path` is what is played; `start` is the configuration to show first, as `Solution.to_dict`
    tells it; `plane` holds singular curves over two coordinates. Raises InputError for what `symkin
    modes --given` refuses.
    """
    require_mechanism(mechanism)
    completed = completed_sliders(mechanism) if given is None else None
    given, note = (given, None) if completed is None else completed
    made = page_model(mechanism, given, start)
    scene = scene_of(mechanism, made.model["links"])
    scene["notes"][:0] = [] if note is None else [note]
    data = {
        "model": made.model,
        "scene": scene,
        "options": _options(mechanism, made.model, path, plane)
        | {"hint": _hint(made.model, scene)},
    }
    return static_template("page.html").render(
        mechanism=mechanism,
        model=made.model,
        css=static_text("page.css"),
        modules=_modules(made.generated),
        data=_in_script(json.dumps(data, allow_nan=False, separators=(",", ":"))),
        boot=static_text("boot.js"),
    )


def _options(
    mechanism: Mechanism,
    model: Mapping[str, Any],
    path: PlayedPath | None,
    plane: Mapping[str, Any] | None,
) -> dict[str, Any]:
    options: dict[str, Any] = {
        "ranges": {name: _range(mechanism, name, model["values"][name]) for name in model["names"]},
        "frameName": mechanism.frame_name,
    }
    if plane is not None:
        options["plane"] = painted_plane(plane)
        limited = {c.name for c in mechanism.coordinates if c.limits is not None}
        for name, (low, high) in zip(plane["names"], plane["ranges"], strict=True):
            if name in options["ranges"] and name not in limited:
                least, most = options["ranges"][name]
                options["ranges"][name] = [min(least, low), max(most, high)]
    if path is not None:
        rows = [[float(v) for v in row] for row in path.rows]
        times = None if path.times is None else [float(t) for t in path.times]
        options["path"] = {
            "title": path.title,
            "names": list(path.names),
            "rows": rows,
            "times": times,
        }
    return options


def _hint(model: Mapping[str, Any], scene: Mapping[str, Any]) -> str:
    """How the pointer moves the platform, or the view where there is none to move."""
    if model["names"] and any(item.get("role") == "platform" for item in scene["items"]):
        return (
            "Drag the platform to move it, with Shift to turn it; drag beside it to turn the view."
        )
    return "Drag to turn the view, wheel or two fingers to zoom."


def _range(mechanism: Mechanism, name: str, value: float) -> list[float]:
    """What a slider spans: the limits, a turn of an angle, or half the size to both sides of a
    length's value.
    """
    turn, half = _TURN[mechanism.angle_unit], 0.5 * mechanism.characteristic_length
    found = next((c for c in mechanism.coordinates if c.name == name), None)
    if found is None:
        return (
            [value - half, value + half] if name in "xyz" else [min(-turn, value), max(turn, value)]
        )
    if found.limits is not None:
        return [mechanism.value_out(found, v) for v in found.limits]
    if found.is_periodic:
        return [min(-turn, value), max(turn, value)]
    if found.is_advancing:
        return [value - 2.0 * turn, value + 2.0 * turn]
    least = -math.inf if found.least is None else found.least
    return [max(least, value - half), value + half]


# --- text -----------------------------------------------------------------------------------------


def _modules(generated: str) -> str:
    """Every module as a script of a type that browsers do not run; boot.js makes modules of
    them.
    """
    texts = {name: static_text(file) for name, file in _MODULES.items()}
    solvers = sorted(
        entry.name
        for entry in files("symkin.page").joinpath("static").iterdir()
        if _is_solver(entry.name)
    )
    texts |= {name.removesuffix(".js"): static_text(name) for name in solvers}
    texts["generated"] = generated
    return "\n".join(
        f'<script type="text/module" data-name="{name}">\n{_in_script(text)}\n</script>'
        for name, text in texts.items()
    )


def _is_solver(name: str) -> bool:
    return name.startswith("solver") and name.endswith(".js")


def _in_script(text: str) -> str:
    """Text that may stand in a script element: `</script` and `<!--`, which stand in strings only,
    are escaped.
    """
    return re.sub(
        r"<(?=/script|!--|script)",
        r"\\x3c" if not text.startswith("{") else r"\\u003c",
        text,
        flags=re.IGNORECASE,
    )


# --- sliders --------------------------------------------------------------------------------------


_NAMED = 4
"""Names that a note lists."""


def completed_sliders(mechanism: Mechanism) -> tuple[dict[str, float], str] | None:
    """Values by name, in the mechanism's units, of as many coordinates as decide its
    configuration, and a note of what was left out or added to the actuated ones; None where these
    decide it, where an example tells what is given, and where no joints do.
    """
    example = mechanism.example
    if example is not None and example.joints is None:
        return None
    names = [c.name for c in mechanism.actuated]
    found = _determination(mechanism, names)
    left_out = [name for name in names if name in found.decided]
    kept = [name for name in names if name not in left_out]
    added = _added(mechanism, kept, found) if found.free else []
    if added is None or not (left_out or added):
        return None
    values = {c.name: mechanism.value_out(c, c.reference[0]) for c in mechanism.actuated}
    if example is not None and example.joints is not None:
        values = dict(zip(names, example.joints, strict=True))
    start = solve(
        mechanism, given={name: values[name] for name in kept} or None, check=False
    ).solution
    if start is None:
        return None
    return {name: float(start.joints[name]) for name in (*kept, *added)}, _note(
        names, left_out, added
    )


def _determination(mechanism: Mechanism, names: Sequence[str]) -> Determination:
    return determination(build_problem(mechanism, tuple(names)))


def _added(mechanism: Mechanism, kept: Sequence[str], found: Determination) -> list[str] | None:
    """Names that bind what the kept ones leave free: of the closure's coordinates, then of joints
    at which loops are cut; None where some motion is left.
    """
    added = list(found.binding)
    free = _determination(mechanism, (*kept, *added)).free
    for c in mechanism.coordinates:
        if not free:
            break
        if c.is_rotation or c.name in (*kept, *added, *found.decided):
            continue
        more = _determination(mechanism, (*kept, *added, c.name))
        if not more.decided:
            added.append(c.name)
            free = more.free
    return None if free else added


def _note(names: Sequence[str], left_out: Sequence[str], added: Sequence[str]) -> str:
    said = []
    if added:
        verb = "has a slider" if len(added) == 1 else "have sliders"
        why = (
            "the actuated joints leave the mechanism free to move"
            if names
            else "no joint of the mechanism is actuated"
        )
        said.append(f"{first_of(added, _NAMED)} {verb}: {why}.")
    if left_out:
        verb, them = ("has", "it") if len(left_out) == 1 else ("have", "them")
        said.append(
            f"{first_of(left_out, _NAMED)} {verb} no slider: other actuated joints decide {them}."
        )
    return " ".join([*said, "--given gives sliders to others."])
