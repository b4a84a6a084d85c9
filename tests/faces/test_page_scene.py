"""What the page draws of marks on links."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from importlib.resources import files
from typing import Any

import numpy as np
import pytest

import symkin
from helpers.inside import build_closure, link_expressions, scene_of
from helpers.joint_types import MADE
from symkin import Mechanism

SHAPES = files("symkin.page").joinpath("static", "shapes.js").read_text(encoding="utf-8")


def points_of(solid: dict[str, Any]) -> Iterator[np.ndarray]:
    """The ends and centres of a solid's parts."""
    for kind, *numbers in solid["parts"]:
        yield from map(np.array, numbers[: 2 if kind == "tube" else 1])


@pytest.mark.parametrize("made", MADE, ids=lambda made: made.__name__)
def test_solids_stand_where_their_marks_are(made: Callable[[], Mechanism]) -> None:
    """Every part is a shape that the page has; those of joints and of rods' ends are no farther
    from their points than a symbol and a half, those between two points about the origin.
    """
    mechanism = made()
    scene = scene_of(mechanism, list(link_expressions(build_closure(mechanism))))
    kinds = set(re.findall(r"export function (\w+)", SHAPES))
    for item in scene["items"]:
        for solid in item.get("solids", ()):
            assert {part[0] for part in solid["parts"]} <= kinds
            if item["kind"] not in ("joint", "rod") or "stretched" in solid:
                continue
            ends = [end["point"] for end in item["at"]]
            places = [np.zeros(3)] if "between" in solid else ends
            for point in points_of(solid):
                away = min(float(np.linalg.norm(point - np.array(place))) for place in places)
                assert away <= 1.5 * scene["symbol"]


@pytest.mark.parametrize("name", ["klann_leg", "excavator_bucket"])
def test_the_grid_of_a_planar_machine_reaches_beyond_all_of_it(name: str) -> None:
    """Where the base stands at one end of what is drawn, too, two steps of the grid and more are
    beside it on all sides: it ended a step before the right edge.
    """
    mechanism = symkin.load(name)
    scene = scene_of(mechanism, list(link_expressions(build_closure(mechanism))))
    axes = np.array([scene["view"]["right"], scene["view"]["up"]])
    bodies = [np.array(item["points"]) for item in scene["items"] if item["kind"] == "body"]
    drawn, lines = np.vstack(bodies) @ axes.T, np.array(scene["grid"]) @ axes.T
    step = np.diff(np.unique(lines[:, 0].round(9)))[0]
    beside = [drawn.min(axis=0) - lines.min(axis=0), lines.max(axis=0) - drawn.max(axis=0)]
    assert np.min(beside) > 2.0 * step
