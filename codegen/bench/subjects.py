"""Machines that the scripts of this folder ask, by name: shipped ones, those of `machines/`, and
maps between joints.
"""

from __future__ import annotations

from pathlib import Path

from asked import Machine
from symkin.formats.load import load

PLACE = Path(__file__).with_name("machines")
PLATFORMS = ("delta", "zhao2000", "zhao2000_links", "ren2008", "ren2008_true", "zhang2009")
ARMS = ("gluon_6l3", "scara", "ur5e", "yao2020")
HOME = (0.0, 0.0, 420.0, 1.0, 0.0, 0.0, 0.0)
"""Home of the platform whose singular reference asks for one, as in generate.py."""
HOMES = {"zhang2009": HOME}
MAPS = {
    "ankle": "upper_motor,lower_motor to ankle.1,ankle.2",
    "four_bar": "crank to follower",
    "bennett": "input to output",
    "sarrus": "foot_x to head_y",
    "slider_crank": "crank to piston",
    "watt_six_bar": "crank to output",
    "stephenson_six_bar": "crank to output",
    "goldberg": "input to output",
    "pantograph_five_bar": "arm1,arm2 to wrist1,plate_pivot",
    "excavator_bucket": "boom_cylinder,stick_cylinder,bucket_cylinder to boom,stick,bucket",
    "spherical_wrist": "motor1,motor2,motor3 to tip1,tip2,tip3",
}
"""Maps between joints: given and found coordinates."""


def machine_of(source: str) -> Machine:
    """The machine of a name or a file; a shipped one goes before one of `machines/`."""
    made = PLACE / f"{source}.toml"
    known = source in (*PLATFORMS, *ARMS, *MAPS) or not made.exists()
    given, find = (
        (tuple(names.split(",")) for names in MAPS[source].split(" to "))
        if source in MAPS
        else ((), ())
    )
    return Machine(load(source if known else made), given, find, HOMES.get(source))
