"""State what can be chosen about generated code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from shlex import quote
from typing import Any, Literal

from symkin.codegen.rod_kernel import is_rod_platform
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
    def package(self) -> bool:
        return "package" in self.also

    @property
    def linuxcnc(self) -> bool:
        return "linuxcnc" in self.also

    @property
    def cpp(self) -> bool:
        return "cpp" in self.also

    @property
    def ros2(self) -> bool:
        return "ros2" in self.also

    @property
    def is_map(self) -> bool:
        """Tell whether joints are mapped to joints."""
        return bool(self.given or self.find)

    def check(self, mechanism: Mechanism) -> None:
        if self.home_relative and not is_rod_platform(mechanism):
            raise InputError(
                f"{mechanism.name}: --home-relative is made for platforms on six rods with a "
                f"spatial pose"
            )
        if self.home is not None and not is_rod_platform(mechanism):
            raise InputError(
                f"{mechanism.name}: --home is made for platforms on six rods with a spatial pose"
            )
        if self.is_map and self.compact:
            raise InputError(
                f"{mechanism.name}: a map between joints is written in one form only; leave "
                f"--compact out"
            )
        if self.is_map and self.geometry != "fixed":
            raise InputError(
                f"{mechanism.name}: a map between joints has its geometry in the code; leave "
                f"--geometry struct out"
            )
        if self.is_map and self.linuxcnc:
            raise InputError(
                f"{mechanism.name}: --linuxcnc needs poses; a map between joints has none: leave "
                f"it out"
            )
        if self.ros2 and (not self.is_map or self.real != "double"):
            raise InputError(
                f"{mechanism.name}: --ros2 writes a transmission between joints: it needs --given, "
                f"--find and --real double"
            )
        if self.linuxcnc and (self.real != "double" or self.home_relative):
            raise InputError(
                f"{mechanism.name}: --linuxcnc needs --real double and no --home-relative: "
                f"LinuxCNC's numbers are doubles"
            )

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
