"""The options of `track` and `mode_graph`."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, TypedDict

from symkin.position.options import JOINTS, START, VALUES
from symkin.verb_options import Option

if TYPE_CHECKING:
    import numpy as np

    from symkin.numeric.levenberg import Progress
    from symkin.position.given import Joints, Values
    from symkin.position.solution import Solution
    from symkin.position.starts import Start
    from symkin.spatial.pose import Pose


Columns = Mapping[str, Any]
"""Values along a path by the names of coordinates: a column for each, or one number for a
coordinate that stands.
"""


class PathOptions(TypedDict, total=False):
    """What tells a path."""

    joints: Annotated[
        "Sequence[Joints] | Mapping[str, Sequence[float]] | np.ndarray | None", Option()
    ]
    poses: Annotated["Sequence[Sequence[float] | Pose] | np.ndarray | None", Option()]
    given: Annotated[Columns | None, Option()]
    times: Annotated[Sequence[float] | None, Option()]
    samples: Annotated[
        int | None, Option("Samples on the path; default 101, or those of the file.", "N")
    ]
    limits: Annotated[bool, Option(default=True)]


class TrackOptions(PathOptions, total=False):
    """Options of `track`."""

    start: Annotated["Solution | Start", START]
    name_modes: Annotated[bool, Option(default=True)]
    notes: Annotated[Sequence[str], Option(default=())]
    progress: Annotated[Callable[[int, int], None] | None, Option()]


class GraphOptions(TypedDict, total=False):
    """Options of `mode_graph`."""

    joints: Annotated["Joints | None", JOINTS]
    given: Annotated["Values | None", VALUES]
    progress: Annotated["Progress | None", Option()]
