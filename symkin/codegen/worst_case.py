"""State the worst case of each function of generated C: bounded by its text, and as measured where
figures are handed in.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

from symkin.codegen.operation_bound import LARGEST_ITERATIONS, USUAL_ITERATIONS, Bound, bounds
from symkin.codegen.text.width import WIDTH, narrowed
from symkin.files.written_files import digest

_SHORT = {"additions": "add", "multiplications": "mul", "divisions": "div"}


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
            lines += [
                f"  {function}: {f['instructions']} instructions, {f['stack']} stack, "
                f"{f['bytes']} code"
                for function in self.usual
                if (f := m["functions"].get(function))
            ]
        return lines

    def rows(self) -> Iterator[tuple[str, str, Bound | None]]:
        """Function, config and bound of each row of the README's table."""
        for function, usual in self.usual.items():
            largest = self.largest[function]
            yield function, "NULL", usual
            if largest != usual:
                yield function, f"{LARGEST_ITERATIONS} iterations", largest


def _numbers(bound: Bound | None) -> dict[str, Any] | None:
    return (
        None if bound is None else {"iterations": bound.iterations, "operations": bound.operations}
    )


def _in_words(bound: Bound | None) -> str:
    if bound is None:
        return "no bound derived"
    counts = [f"{count} {_SHORT.get(name, name)}" for name, count in bound.operations.items()]
    return ", ".join([*([f"{bound.iterations} iterations"] if bound.iterations else []), *counts])


def _wrapped(text: str) -> list[str]:
    return wrap(text, WIDTH - 4, initial_indent="  ", subsequent_indent="    ")
