"""What every study shares: its table, whose rows say where the paper has them and what was run, and
the files it writes.

    item | place in the paper | what was run | paper | computed | verdict

What was run is read off the result that a row quotes (`evidence`), not typed beside it: a list of
modes says its method, starts and seed, a solution its solver, a function its name. The verdict of a
row with numbers from the paper is taken from the difference and the digits printed; errors of the
paper are shown by computation and listed below the table.
"""

from __future__ import annotations

import json
from argparse import ArgumentParser
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.table import Table

from studies import SCRIPTS
from symkin import Modes, SolveResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VERDICTS = ("reproduced", "differs", "refuted", "outside", "-")
"""What a row may say: "-" where the paper has no value; "outside" where an item lies beyond
kinematics or the printed data.
"""


@dataclass
class Report:
    """Rows of a study, gathered in order; `finish` prints them and writes NAME.json, NAME.png and
    NAME.md.
    """

    name: str
    title: str
    seed: int | None = None
    rows: list[dict[str, Any]] = field(default_factory=list)
    errata: list[str] = field(default_factory=list)

    def row(
        self,
        quantity: str,
        paper: Any,
        computed: Any,
        unit: str = "",
        *,
        run: Any = None,
        place: str = "",
        tolerance: float | None = None,
        verdict: str | None = None,
        volatile: bool = False,
    ) -> None:
        """Add one line. `paper` is None where the paper does not say; `run` is what computed the
        value: a result of symkin, a function, or several of them; `tolerance` defaults to one unit
        of the last digit that the paper prints. `volatile` marks times and the like, which differ
        from run to run.
        """
        difference = None
        if _is_numeric(paper) and _is_numeric(computed) and np.shape(paper) == np.shape(computed):
            delta = np.asarray(computed, dtype=float) - np.asarray(paper, dtype=float)
            difference = delta.tolist()
        if verdict is None:
            verdict = _verdict(paper, computed, difference, tolerance)
        if verdict not in VERDICTS:
            raise SystemExit(
                f"{self.name}: verdict {verdict!r} of {quantity!r}; allowed: {', '.join(VERDICTS)}"
            )
        self.rows.append(
            {
                "quantity": quantity,
                "place": place,
                "run": evidence(run),
                "paper": paper,
                "computed": computed,
                "difference": difference,
                "unit": unit,
                "verdict": verdict,
                "volatile": volatile,
            }
        )

    def outside(self, quantity: str, place: str, reason: str) -> None:
        """Add an item of the paper that is not computed, with the reason."""
        self.row(quantity, None, reason, place=place, run=None, verdict="outside")

    def erratum(self, text: str, *, shown: bool) -> None:
        """Add an error of the paper; `shown` is the computation's verdict, and a claim that fails
        stops the study.
        """
        if not shown:
            raise SystemExit(f"{self.name}: the computation does not show the erratum: {text}")
        self.errata.append(text)

    def finish(self, figure: Figure, folder: Path, **more: Figure) -> None:
        """Print the table; write the picture, `more` as NAME_KEY.png, the JSON and the table as
        Markdown.
        """
        folder.mkdir(parents=True, exist_ok=True)
        pictures = {
            folder / f"{self.name}.png": figure,
            **{folder / f"{self.name}_{k}.png": f for k, f in more.items()},
        }
        data, page = (folder / f"{self.name}.{suffix}" for suffix in ("json", "md"))
        for path, picture in pictures.items():
            picture.savefig(path, dpi=130)
        content = {
            "study": self.name,
            "title": self.title,
            "seed": self.seed,
            "rows": self.rows,
            "errata": self.errata,
        }
        data.write_text(json.dumps(content, indent=1, default=_plain) + "\n")
        page.write_text(self.markdown())
        self._print()
        print("written: " + ", ".join(str(path) for path in (*pictures, data, page)))

    def markdown(self) -> str:
        """Write the table as a page of docs/papers; rows that differ from run to run are left
        out.
        """
        seed = "" if self.seed is None else f", seed {self.seed}"
        lines = [
            f"# {self.title}",
            "",
            f"Written by `python studies/{SCRIPTS[self.name]} -o out`{seed}.",
            "",
        ]
        lines += [
            "| item | in the paper | what was run | paper | computed | verdict |",
            "|---|---|---|---|---|---|",
        ]
        for row in self.rows:
            if not row["volatile"]:
                lines.append(
                    "| "
                    + " | ".join(
                        cell.replace("|", "\\|").replace("\n", " ") for cell in _cells(row)
                    )
                    + " |"
                )
        if self.errata:
            lines += [
                "",
                "Errors of the paper, shown by computation:",
                "",
                *(f"- {text}" for text in self.errata),
            ]
        return "\n".join(lines) + "\n"

    def _print(self) -> None:
        console = Console(width=170)
        table = Table(
            "item",
            "in the paper",
            "what was run",
            "paper",
            "computed",
            "verdict",
            title=self.title,
            title_justify="left",
        )
        for row in self.rows:
            table.add_row(*(cell.replace("[", r"\[") for cell in _cells(row)))
        console.print(table)
        for text in self.errata:
            console.print(f"Erratum, shown by computation: {text}", markup=False, highlight=False)
        if self.seed is not None:
            console.print(f"seed {self.seed}")


def evidence(run: Any) -> list[dict[str, Any]]:
    """Read off the results themselves what was run; a result of a study's own says it by its method
    `evidence`.
    """
    if run is None:
        return []
    if isinstance(run, list | tuple):
        return [entry for part in run for entry in evidence(part)]
    if isinstance(run, Modes):
        method = run.method if run.starts is None else f"{run.method}, {run.starts} starts"
        return [
            {
                "by": "symkin.modes",
                "method": run.method,
                "starts": run.starts,
                "seed": run.seed,
                "text": f"modes: {method}",
            }
        ]
    if isinstance(run, SolveResult):
        return [
            {
                "by": "symkin.solve",
                "method": run.method,
                "text": f"solve: {run.method}, {run.iterations} steps",
            }
        ]
    if hasattr(run, "evidence"):
        return [run.evidence()]
    if callable(run):
        name = getattr(run, "__qualname__", type(run).__name__)
        return [{"by": f"{run.__module__}.{name}", "method": name, "text": f"{name}()"}]
    return [{"by": "study", "method": str(run), "text": str(run)}]


def options_parser(description: str | None, seed: int | None = None) -> ArgumentParser:
    """Read `-o`, and `--seed` where a study has one; a study adds its own options."""
    parser = ArgumentParser(description=description)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("out"),
        help="folder for the PNG and the JSON (default: out)",
    )
    if seed is not None:
        parser.add_argument(
            "--seed", type=int, default=seed, help=f"seed of the random numbers (default: {seed})"
        )
    return parser


def folder_from_arguments(description: str | None) -> Path:
    """Return the folder that `-o` names; default `out`."""
    folder: Path = options_parser(description).parse_args().output
    return folder


def new_figure(width: float, height: float) -> Figure:
    """Open a figure that needs no display."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def of_all_modes(loci: Any) -> Any:
    """Singular curves of which those of other working modes are drawn as the others are."""
    curves = [replace(c, in_mode=np.ones_like(c.in_mode)) for c in loci.curves]
    return replace(loci, curves=tuple(curves))


def equal_axes(
    axes: Any, low: Sequence[float], high: Sequence[float], unit: str, step: float
) -> None:
    """Frame a 3-D picture of the box from `low` to `high` at equal scales, ticks at multiples of
    `step`, the unit on each axis.
    """
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(np.subtract(high, low), zoom=1.12)
    axes.patch.set_alpha(0.0)  # its ground would cover labels of pictures beside it
    for axis, name, a, b in zip(
        (axes.xaxis, axes.yaxis, axes.zaxis), "xyz", low, high, strict=True
    ):
        axis.set_ticks(step * np.arange(np.ceil(a / step), np.floor(b / step) + 1))
        axis.set_label_text(f"{name} [{unit}]")
        axis.set_tick_params(labelsize=8, pad=0)
    axes.zaxis.set_rotate_label(False)
    axes.zaxis.label.set_rotation(90)


def _verdict(paper: Any, computed: Any, difference: Any, tolerance: float | None) -> str:
    if paper is None:
        return "-"
    if difference is None:
        return "reproduced" if paper == computed else "differs"
    allowed = np.vectorize(_last_digit)(paper) if tolerance is None else tolerance
    return "reproduced" if np.all(np.abs(difference) <= 1.0001 * np.asarray(allowed)) else "differs"


def _last_digit(value: float) -> float:
    """Return one unit of the last digit that a printed number shows; half a unit for whole numbers,
    which are counts.
    """
    text = repr(float(value))
    if "e" in text:
        mantissa, exponent = text.split("e")
        return float(10.0 ** (int(exponent) - len(mantissa.partition(".")[2])))
    decimals = text.partition(".")[2].rstrip("0")
    return float(10.0 ** -len(decimals)) if decimals else 0.5


def _cells(row: dict[str, Any]) -> list[str]:
    unit = f" [{row['unit']}]" if row["unit"] else ""
    run = "; ".join(dict.fromkeys(entry["text"] for entry in row["run"])) or "-"
    return [
        row["quantity"] + unit,
        row["place"] or "-",
        run,
        _text(row["paper"]),
        _text(row["computed"]),
        row["verdict"],
    ]


def _is_numeric(value: Any) -> bool:
    if value is None or isinstance(value, str | bool):
        return False
    try:
        return bool(np.all(np.isfinite(np.asarray(value, dtype=float))))
    except (TypeError, ValueError):
        return False


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} does not go into JSON")


def _text(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, float | np.floating):
        return f"{value + 0.0:.6g}"  # no zero has a sign
    if isinstance(value, list | tuple | np.ndarray):
        return ", ".join(_text(v) for v in value)
    return str(value)
