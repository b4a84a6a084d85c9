"""The picture of a singularity: the configuration, with the axes of the platform's motions that the
actuated joints do not hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from symkin.drawing.layout import layout_of
from symkin.plots.figures import Panel, figure_of_panels
from symkin.plots.picture_options import looks_of
from symkin.singularities.singularity_result import Singularity
from symkin.text import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figure_of_singularity(
    found: Singularity, *, names: str = "none", views: str | Sequence[str] = "main"
) -> Figure:
    """A panel for each view: the mechanism at the configuration; platform motions as dashed axes,
    translations as arrows. Where coordinates drive that are told by name, the rates of joints that
    move while these stand are written above it.
    """
    solution, mechanism = found.solution, found.solution.mechanism
    count = found.uncontrolled_freedoms
    usual = "regular" if found.given or not count else "singular everywhere"
    kinds = ", ".join(found.kinds) + " singularity" if found.kinds else usual
    distances = ", ".join(f"{kind} {plain(value):.3g}" for kind, value in found.distances.items())
    facts = [f"distance from singularities (0 singular): {distances}"]
    if found.given:
        facts.insert(0, f"driven by {', '.join(found.given)}")
        rates = [
            ", ".join(f"{name} {rate:.4g}" for name, rate in motion.items())
            for motion in found.motions
            if found.rank_loss
        ]
        texts = [f"free to move: {motion}" for motion in rates]
        texts += [f"freedoms that are not driven, everywhere: {count}"] * (count > 0)
    else:
        texts = [str(twist) for twist in found.twists]
    twists = () if found.given else found.twists
    layout = layout_of(mechanism).at(solution.link_poses)
    panel = Panel(kinds, "\n".join(texts), layout, twists)
    return figure_of_panels(mechanism, [panel], facts, **looks_of(mechanism, names, views))
