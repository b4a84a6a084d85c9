"""State what can be chosen about generated code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from shlex import quote
from typing import Any, Literal

from symkin.codegen.steps.rod_kernel import is_rod_platform
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism


@dataclass(frozen=True)
class Options:
    """`real`: the C type of numbers. `home_relative`: joint values and positions are changes from
    home. `geometry`: numbers in the code, or a struct that is given with each call. `home`: the
    platform's pose about which the order of pivots is chosen and test poses lie (x, y, z, qw, qx,
    qy, qz). `given`, `find`: names of the coordinates of a map between joints. `also`: more files,
    for package managers, LinuxCNC, C++ or ROS 2. `compact`: the least code, at some cost of
    instructions.
    """

    real: Literal["float", "double"] = "double"
    home_relative: bool = False
    geometry: Literal["fixed", "struct"] = "fixed"
    home: tuple[float, ...] | None = None
    given: tuple[str, ...] = ()
    find: tuple[str, ...] = ()
    also: tuple[Literal["package", "linuxcnc", "cpp", "ros2"], ...] = ()
    compact: bool = False

    @classmethod
    def of(cls, told: Mapping[str, Any]) -> Options:
        """What a call of `write_firmware` asks."""
        home = told["home"]
        names = {key: tuple(told[key]) for key in ("given", "find", "also")}
        pose = None if home is None else tuple(float(v) for v in home)
        return cls(**{**told, **names, "home": pose})

    @property
    def is_map(self) -> bool:
        """Tell whether joints are mapped to joints."""
        return bool(self.given or self.find)

    def check(self, mechanism: Mechanism) -> None:
        """Raises InputError for options that do not fit each other, or the mechanism."""
        on_rods, of_map, also = is_rod_platform(mechanism), self.is_map, self.also
        refused = {
            "--home-relative is made for platforms on six rods with a spatial pose": (
                self.home_relative and not on_rods
            ),
            "--home is made for platforms on six rods with a spatial pose": (
                self.home is not None and not on_rods
            ),
            "a map between joints is written in one form only; leave --compact out": (
                of_map and self.compact
            ),
            "a map between joints has its geometry in the code; leave --geometry struct out": (
                of_map and self.geometry != "fixed"
            ),
            "--linuxcnc needs poses; a map between joints has none: leave it out": (
                of_map and "linuxcnc" in also
            ),
            "--ros2 writes a transmission between joints: it needs --given, --find and --real "
            "double": "ros2" in also and (not of_map or self.real != "double"),
            "--linuxcnc needs --real double and no --home-relative: LinuxCNC's numbers are "
            "doubles": ("linuxcnc" in also and (self.real != "double" or self.home_relative)),
        }
        for reason, applies in refused.items():
            if applies:
                raise InputError(f"{mechanism.name}: {reason}")

    @property
    def arguments(self) -> str:
        """Write the options as on the command line."""
        parts = [f"--real {self.real}"]
        if self.home_relative:
            parts.append("--home-relative")
        if self.geometry != "fixed":
            parts.append(f"--geometry {self.geometry}")
        if self.home is not None:
            parts.append("--home " + ",".join(f"{v:g}" for v in self.home))
        if self.compact:
            parts.append("--compact")
        if self.is_map:
            parts += [
                f"--given {quote(','.join(self.given))}",
                f"--find {quote(','.join(self.find))}",
            ]
        return " ".join([*parts, *(f"--{name}" for name in self.also)])
