"""Write what package managers of microcontrollers read beside the sources: PlatformIO, Arduino and
Zephyr.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from symkin.codegen.text.templates import fill
from symkin.model.mechanism import Mechanism

_URL = "https://pypi.org/project/symkin"
_LONGEST = 80
"""Characters of the sentence that a library manager shows in a line."""


def package_files(mechanism: Mechanism, values: Mapping[str, object]) -> dict[str, str]:
    """Text of each file by its name. Arduino compiles `src/` alone, so that test and example stay
    out; PlatformIO and Zephyr name the source.
    """
    name = mechanism.name
    shown = {**values, "sentence": _sentence(mechanism), "url": _URL}
    templates = {
        "library.json": "library.json",
        "library.properties": "library.properties",
        f"src/{name}.h": "arduino.h",
        f"src/{name}.c": "arduino.c",
        "zephyr/module.yml": "module.yml",
        "zephyr/CMakeLists.txt": "zephyr.cmake",
        "zephyr/Kconfig": "Kconfig",
    }
    return {file: fill(template, shown) for file, template in templates.items()}


def _sentence(mechanism: Mechanism) -> str:
    """The title as one line that JSON, properties and Kconfig all take."""
    title = re.sub(r"""[^ -~]|["'\\$=]""", " ", mechanism.title or "")
    return " ".join(f"Kinematics of {mechanism.name} {title}".split())[:_LONGEST].rstrip()
