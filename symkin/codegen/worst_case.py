"""State the worst case of each function of generated C: bounded by its text, and as measured where
figures are handed in.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

from symkin.codegen.operation_bound import LARGEST_ITERATIONS, USUAL_ITERATIONS, Bound, bounds
from symkin.codegen.text.width import WIDTH, narrowed
from symkin.files.written_files import digest

_SHORT = {"additions": "add", "multiplications": "mul", "divisions": "div"}
_NAMES = ("additions", "multiplications", "divisions", "sqrt", "sin", "cos", "atan2")
_HEAD = """## Worst case

No function calls itself, and every loop ends after a number of passes that the code tells, so a
call takes at most these operations: additions and subtractions, multiplications, divisions, and
calls of sqrt, sin, cos and atan2. They are counted in the code that was written, the larger side of
each choice and loops as often as they can go; comparisons, copies and signs are left out.
Iterations are the passes of loops that `max_iterations` bounds. A dash: the code does not tell a
bound."""
_TO_MEASURE = """Instructions, stack and bytes on a Cortex-M4F (float) or M7 (double):
`python codegen/bench/worst.py FOLDER` in symkin's sources, with GCC for ARM and QEMU."""


@dataclass(frozen=True)
class WorstCase:
    """Bounds of each function by its name without the prefix, with the iterations of no config and
    the most that one allows; figures of this very code that somebody measured.
    """

    usual: Mapping[str, Bound | None]
    largest: Mapping[str, Bound | None]
    measured: Mapping[str, Any] | None

    @staticmethod
    def of(name: str, source: str, measured: Mapping[str, Any] | None) -> WorstCase:
        """`measured`: what codegen/bench/worst.py found; it is left out where it is that of another
        text.
        """
        fresh = (
            measured if measured and measured["code"] == digest(narrowed(source).encode()) else None
        )
        found = bounds(source, (USUAL_ITERATIONS, LARGEST_ITERATIONS))
        usual, largest = (
            {key.removeprefix(f"{name}_"): bound for key, bound in part.items()} for part in found
        )
        return WorstCase(usual, largest, fresh)

    def manifest(self) -> dict[str, Any]:
        """As the manifest has it."""
        bound = {
            f: {"usual": _numbers(self.usual[f]), "largest": _numbers(self.largest[f])}
            for f in self.usual
        }
        return {"bound": bound, "measured": self.measured}

    def header_lines(self) -> list[str]:
        """Lines of the header's comment."""
        lines = [
            "",
            "Worst case of a call, with NULL as config (README.md says how it is known and has "
            "255 iterations):",
        ]
        for function, bound in self.usual.items():
            lines += _wrapped(f"{function}: {_in_words(bound)}")
        if self.measured:
            m = self.measured
            lines += _wrapped(
                f"measured ({m['processor']}, {m['compiler']}, {m['inputs']} inputs, seed "
                f"{m['seed']}): instructions, bytes of stack "
                "with callees, bytes of code with callees but without those of libm:"
            )
            for function, f in self._measured_functions():
                lines.append(
                    f"  {function}: {f['instructions']} instructions, {f['stack']} stack, "
                    f"{f['bytes']} code"
                )
        return lines

    def _measured_functions(self) -> list[tuple[str, Mapping[str, int]]]:
        """Figures of each function, in the order of the bounds."""
        found = self.measured["functions"] if self.measured else {}
        return [(function, found[function]) for function in self.usual if function in found]

    def chapter(self) -> str:
        """The section of the README."""
        head = (
            "| function | config | iterations | additions | multiplications | divisions | sqrt | "
            "sin | cos | atan2 |"
        )
        rows = [head, "|" + "---|" * 10]
        for function in self.usual:
            kinds = (
                (self.usual[function], "NULL"),
                (self.largest[function], f"{LARGEST_ITERATIONS} iterations"),
            )
            rows += [
                _row(function, config, bound)
                for bound, config in (kinds if kinds[0][0] != kinds[1][0] else kinds[:1])
            ]
        return "\n\n".join([_HEAD, "\n".join(rows), *self._measured_lines()])

    def _measured_lines(self) -> list[str]:
        if not self.measured:
            return [_TO_MEASURE]
        m = self.measured
        library = ", ".join(f"`{name}`" for name in m["library"])
        said = (
            f"Worst case, measured: {m['processor']} under QEMU, {m['compiler']}, the most of "
            f"{m['inputs']:,} inputs (seed {m['seed']}; random ones, "
            "lines that are refused after all iterations and numbers that are refused at once "
            "among them, half of them changes of the dearest "
            "so far), counted to 5 instructions, `config` NULL. Stack with all callees, those of "
            "the library too; bytes of code and constants "
            f"that a program links which calls this function alone, without and with the library "
            f"({library or 'of which nothing is called'}). All functions together: "
            f"{m['object_bytes']:,} bytes without the library."
        )
        rows = [
            "| function | instructions | stack | bytes | with library |",
            "|---|---|---|---|---|",
        ]
        for function, f in self._measured_functions():
            rows.append(
                f"| `{function}` | {f['instructions']:,} | {f['stack']:,} | {f['bytes']:,} | "
                f"{f['bytes_with_library']:,} |"
            )
        return ["\n".join(wrap(said, 130, break_long_words=False)), "\n".join(rows)]


def _numbers(bound: Bound | None) -> dict[str, Any] | None:
    return (
        None if bound is None else {"iterations": bound.iterations, "operations": bound.operations}
    )


def _in_words(bound: Bound | None) -> str:
    if bound is None:
        return "no bound derived"
    counts = [f"{count} {_SHORT.get(name, name)}" for name, count in bound.operations.items()]
    return ", ".join([*([f"{bound.iterations} iterations"] if bound.iterations else []), *counts])


def _row(function: str, config: str, bound: Bound | None) -> str:
    values = (
        ["-"] * 8
        if bound is None
        else [f"{bound.iterations}", *(f"{bound.operations.get(name, 0):,}" for name in _NAMES)]
    )
    return f"| `{function}` | {config} | {' | '.join(values)} |"


def _wrapped(text: str) -> list[str]:
    return wrap(text, WIDTH - 4, initial_indent="  ", subsequent_indent="    ")
