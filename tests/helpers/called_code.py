"""Call each function of a folder of generated C from Python, at the configurations of its vectors,
with any of its arguments changed.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from helpers import firmware_tools as tools

UNDEFINED = ("-fsanitize=undefined", "-fsanitize=float-cast-overflow")
ROOM = 1024
"""Numbers of an argument, as many as the largest has and more."""
_ROW = re.compile(r"\{([^{}]*)\}")
_TABLE = re.compile(r"_vector_(\w+)\[\d+\]\[\d+\] = \{\n(.*?)\n\};", re.S)
_BEFORE = 4.0
"""What numbers hold before a call, where it does not begin at a guess."""


@dataclass(frozen=True)
class Said:
    """What a call left: its status, each result's numbers, these to the bit, and the info."""

    status: int
    results: list[tuple[float, ...]]
    bits: list[bytes]
    info: dict[str, float]


class CalledCode:
    """A folder's code, compiled: `functions` that have a status, as its header declares them, and
    `listing` ones that have a count. Undefined behaviour is told on stderr.
    """

    def __init__(self, folder: Path, place: Path) -> None:
        calls = tools.bench_module("calls")
        self.name, self.kind, manifest = calls.manifest_of(folder)
        self.is_float = manifest["options"]["real"] == "float"
        self.number = ctypes.c_float if self.is_float else ctypes.c_double
        header = (folder / f"{self.name}.h").read_text()
        self.joints = int(re.findall(r"_JOINTS \((\d+)\)", header)[0])
        declared = re.findall(rf"^{self.name}_status {self.name}_(\w+)\(", header, re.M)
        known = {f.name: f for f in calls._FUNCTIONS[self.kind]}
        self.functions = [known[name] for name in declared]
        self.listing = [calls._ALL] if f"int {self.name}_{calls._ALL.name}(" in header else []
        self.geometry = self._nominal(header)
        vectors = _TABLE.findall((folder / f"{self.name}_vectors.h").read_text())
        self.tables = {
            name: [[_value(v.strip()) for v in row.split(",")] for row in _ROW.findall(body)]
            for name, body in vectors
        }
        source = str(folder / f"{self.name}.c")
        tools.built("gcc", place, [source], "code.so", "-O2", "-shared", "-fPIC", *UNDEFINED)
        self._library = ctypes.CDLL(str(place / "code.so"))

        class Info(ctypes.Structure):
            _fields_ = (
                ("iterations", ctypes.c_uint8),
                ("residual", self.number),
                ("step", self.number),
                ("min_pivot", self.number),
                ("joint", ctypes.c_uint8),
            )

        self.info = Info

    def _nominal(self, header: str) -> list[float]:
        """The numbers of a struct of geometry; nothing where it is in the code."""
        found = re.search(r"_NOMINAL( \\\n.*?[^\\])\n", header, re.S)
        text = re.sub(r"/\*.*?\*/", "", found[1]) if found else ""
        return [float(v) for v in re.findall(r"-?\d[\d.]*(?:e[-+]?\d+)?", text)]

    def given(self, function: Any, k: int) -> list[list[float]]:
        """What a function takes, at the vector k; an empty list is a branch."""
        return [self._numbers(function, value, k) for value in function.takes]

    def begun(self, function: Any, k: int) -> list[list[float]]:
        """What results hold before a call: of one that moves, the vector's guess."""
        if function.moves:
            return [self._guess(function.gives[0].name, k)]
        return [[_BEFORE] * value.numbers(self.joints) for value in function.gives]

    def _guess(self, of: str, k: int) -> list[float]:
        is_joints = of == "joints"
        table = "joint_guesses" if is_joints and self.kind == "map" else "guesses"
        return self._row(table, k)

    def _row(self, table: str, k: int) -> list[float]:
        rows = self.tables[table]
        return [*rows[k % len(rows)]]

    def _numbers(self, function: Any, value: Any, k: int) -> list[float]:
        tables = {"joints": "joints", "found": "found", "pose": "poses", "to": "poses"}
        if value.name in tables:
            return self._row(tables[value.name], k)
        if value.name == "from":
            return self._row("poses", k + 1)
        if value.name == "guess":
            return self._guess(function.gives[0].name, k)
        return [0.01 * (1 + (i + k) % 3) for i in range(value.numbers(self.joints))]

    def call(
        self,
        function: Any,
        given: Sequence[Sequence[float]],
        begun: Sequence[Sequence[float]],
        on: tuple[int, int] | None = None,
        geometry: Sequence[float] = (),
    ) -> Said:
        """Call a function; `on`: a result, and the argument on whose place it lies, behind the last
        one the geometry.
        """
        places = [self._place(numbers) if numbers else 0 for numbers in given]
        places += [self._place(geometry or self.geometry)] if self.geometry else []
        results = [self._place(numbers) for numbers in begun]
        if on is not None:
            results[on[0]] = places[on[1]]
        info = self.info(255, -1.0, -1.0, -1.0, 255)
        first = [*places[len(given) :], *[None] * function.config]
        last = [ctypes.byref(info)] * function.info
        call = getattr(self._library, f"{self.name}_{function.name}")
        status = call(*first, *places[: len(given)], *results, *last)
        widths = [value.numbers(self.joints) for value in function.gives]
        found = [tuple(r[:n]) for r, n in zip(results, widths, strict=True)]
        told = {name: getattr(info, name) for name, _ in self.info._fields_}
        return Said(status, found, self.bits(found), told)

    def bits(self, arrays: Sequence[Sequence[float]]) -> list[bytes]:
        """The numbers of arrays to the bit."""
        return [bytes((self.number * len(numbers))(*numbers)) for numbers in arrays]

    def _place(self, numbers: Sequence[float]) -> Any:
        return (self.number * ROOM)(*numbers, *[_BEFORE] * (ROOM - len(numbers)))


def _value(text: str) -> float:
    return float.fromhex(text.removesuffix("f") if "p" in text else text)
