"""Write a ROS 2 package round a map between joints: a transmission of ros2_control, its loader,
package and plugin descriptions, and what a URDF says of it.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from html import escape

from symkin.codegen.map.joint_map import JointMap
from symkin.codegen.text.templates import fill
from symkin.formats.graph_form import METRES
from symkin.model.joint import Coordinate

_FILES = {
    "{name}_transmission.hpp": "ros2.hpp",
    "{name}_transmission_loader.cpp": "ros2_loader.cpp",
    "{name}_transmission.xml": "ros2_plugin.xml",
    "{name}_transmission.urdf": "ros2.urdf",
    "CMakeLists.txt": "ros2.cmake",
    "package.xml": "ros2_package.xml",
}
"""Files of the package, and their templates."""


def ros2_files(made: JointMap, values: Mapping[str, object]) -> dict[str, str]:
    """Write each file of the package, by its name; handles are in metres, radians, N and Nm, so
    that power is the same on both sides of each of them.
    """
    sides = {"actuator": made.given, "joint": made.found}
    shown = {
        **values,
        "package": f"{made.name.lower()}_transmission",
        "title": escape(made.mechanism.title or made.name),
    }
    for side, coordinates in sides.items():
        metres = METRES[made.mechanism.length_unit]
        units = [1.0 if c.is_angular else metres for c in coordinates]
        home = made.reference_of(coordinates)
        shown |= {
            f"{side}_names": ", ".join(json.dumps(c.name, ensure_ascii=False) for c in coordinates),
            f"{side}_units": ", ".join(map(repr, units)),
            f"{side}_home": ", ".join(repr(float(v)) for v in home),
            f"{side}_tags": "\n".join(_tags(side, coordinates)),
        }
    return {
        f"ros2/{file.format(name=made.name)}": fill(template, shown)
        for file, template in _FILES.items()
    }


def _tags(side: str, coordinates: Sequence[Coordinate]) -> list[str]:
    """Elements of a URDF's transmission, one a coordinate."""
    offset = "<offset>0.0</offset>" if side == "joint" else ""
    return [
        f'      <{side} name="{escape(c.name)}" role="{side}{i}">'
        f"<mechanical_reduction>1.0</mechanical_reduction>{offset}</{side}>"
        for i, c in enumerate(coordinates, 1)
    ]
