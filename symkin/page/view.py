"""The page as a file, in the browser, and in a notebook."""

from __future__ import annotations

import webbrowser
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from symkin.assembly.modes import modes
from symkin.computed_once import cached_property
from symkin.errors import InputError, NoConfigurationError
from symkin.files.outputs import check_output, write_output
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.numeric.cache_folder import cache_folder, folder_fault
from symkin.page.page import PlayedPath, page_html
from symkin.page.played_path import played_path
from symkin.position.given import read_given
from symkin.position.solution import Solution
from symkin.spatial.pose import Pose

_HEIGHT = 640
"""Height of the page in a notebook, pixels."""


@dataclass(frozen=True, eq=False)
class View:
    """A page that moves: `html` is its text, `save` writes it, `open` shows it in the browser; a
    notebook shows it in place.
    """

    mechanism: Mechanism
    given: Mapping[str, float] | None = None
    path: PlayedPath | None = None
    start: Mapping[str, Any] | None = None
    plane: Mapping[str, Any] | None = None

    @cached_property
    def html(self) -> str:
        """The whole page as one HTML text."""
        return page_html(self.mechanism, self.given, self.path, self.start, self.plane)

    def save(self, path: Path | str) -> Path:
        """Write the page. Raises InputError for a file that cannot be written or has another suffix
        than .html.
        """
        check_output(path, (".html", ".htm"), "view")
        write_output(path, self.html)
        return Path(path)

    def open(self) -> Path:
        """Write the page into the cache folder and show it in the browser; returns where it is."""
        place = cache_folder() / "pages" / f"{self.mechanism.name}.html"
        try:
            place.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{place.parent}: the folder cannot be made ({error.strerror}); write the page "
                f"with --html"
            ) from None
        fault = folder_fault(place.parent.parent) or folder_fault(place.parent)
        if fault is not None:
            raise InputError(f"{fault}; or write the page with --html")
        write_output(place, self.html)
        webbrowser.open(place.as_uri())
        return place

    def _repr_html_(self) -> str:
        text = escape(self.html, quote=True)
        return (
            f'<iframe srcdoc="{text}" title="{escape(self.mechanism.name)}, moving" width="100%" '
            f'height="{_HEIGHT}" '
            'style="border: 1px solid #dde3ea; border-radius: 8px" allow="fullscreen"></iframe>'
        )

    def __repr__(self) -> str:
        return (
            f"the page of {self.mechanism.name}; .save('{self.mechanism.name}.html') writes it, "
            f".open() shows it"
        )


def view_mechanism(
    mechanism: Mechanism,
    joints: Sequence[float] | Mapping[str, float] | None = None,
    given: Mapping[str, float] | None = None,
    path: PlayedPath | Path | str | None = None,
    pose: Sequence[float] | Pose | None = None,
) -> View:
    """The page of a mechanism with sliders for its actuated joints, or for the coordinates `given`
    by name; it begins with the first row of a `path` (a CSV file, or rows), or with the first
    working mode at a `pose`. Raises InputError for values without a configuration.
    """
    require_mechanism(mechanism)
    if joints is not None and given is not None:
        raise InputError(
            "joints and given are both told; joints are the actuated ones, given any coordinates: "
            "give one of them"
        )
    if isinstance(given, Mapping) and any(map(np.ndim, given.values())):
        raise InputError(
            "given (--given): pose=... is a whole pose, and sliders have single coordinates: give "
            "pose (--pose X,Y,Z,QW,QX,QY,QZ), or x, y, z, azimuth, tilt, torsion one by one"
        )
    if pose is not None:
        if joints is not None or given is not None or path is not None:
            other = "joints" if joints is not None else "path" if given is None else "given"
            raise InputError(
                f"view: both pose (--pose) and {other} (--{other}) are given; each tells where the "
                f"page begins: give one of them"
            )
        found = modes(mechanism, pose=pose)
        if not len(found):
            raise NoConfigurationError(
                f"view: {mechanism.name} has no configuration at this pose; "
                f"{'; '.join(found.notes) or 'symkin modes tells more'}"
            )
        return view_solution(found[0])
    played = played_path(mechanism, path, given) if isinstance(path, (str, Path)) else path
    if joints is not None:
        ordered = read_given(mechanism, joints, None).echo["joints"]
        given = {c.name: value for c, value in zip(mechanism.actuated, ordered, strict=True)}
    if given is None and played is not None:
        return View(
            mechanism, dict(zip(played.names, played.rows[0], strict=True)), played, played.start
        )
    return View(mechanism, given, played)


def view_solution(solution: Solution, given: Mapping[str, Any] | None = None, **shown: Any) -> View:
    """The page that begins at a configuration, with sliders for the coordinates `given` by name,
    else for the actuated joints.
    """
    single = given if given and all(isinstance(v, (int, float)) for v in given.values()) else None
    values = single or {c.name: solution.joints[c.name] for c in solution.mechanism.actuated}
    sliders = {name: float(value) for name, value in values.items()} or None
    return View(solution.mechanism, sliders, start=solution.to_dict(), **shown)
