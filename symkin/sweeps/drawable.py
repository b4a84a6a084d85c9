"""Which named points and joints of a sweep can be drawn: said before anything is computed."""

from __future__ import annotations

from collections.abc import Sequence

from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.text import meant, shown


def check_drawable(
    mechanism: Mechanism, quantity: str, swept: Sequence[str], names: Sequence[str]
) -> bool:
    """Whether names are those of points and not of joints. Raises InputError for names of neither,
    of both, and where what they stand for is not stored or is what is swept.
    """
    points = [point.name for point in mechanism.link_points]
    joints = [c.name for c in mechanism.coordinates if not c.is_rotation and c.name not in swept]
    for name in names:
        if name not in points and name not in joints:
            allowed = (
                f"points {', '.join(points) or 'none'}; joints that are not swept "
                f"{', '.join(joints) or 'none'}"
            )
            raise InputError(
                f"of: {shown(name)} is no point and no joint to "
                f"draw{meant(name, [*points, *joints])}; allowed: {allowed}"
            )
    if quantity != "modes":
        raise InputError(
            f"of: quantity = {quantity!r} stores no points and joints; sweep with quantity = "
            f"'modes'"
        )
    of_points = [name in points for name in names]
    if any(of_points) and not all(of_points):
        raise InputError(f"of: {', '.join(names)} are points and joints; draw the one or the other")
    return all(of_points)
