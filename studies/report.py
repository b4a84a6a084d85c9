"""What every study shares: its table `quantity | paper | computed | difference`, and the files it writes."""

from __future__ import annotations

import json
from argparse import ArgumentParser
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.table import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass
class Report:
    """Rows of a study, gathered in order; `finish` prints them and writes NAME.json and NAME.png into a folder."""

    name: str
    title: str
    seed: int | None = None
    rows: list[dict[str, Any]] = field(default_factory=list)
    errata: list[str] = field(default_factory=list)

    def row(self, quantity: str, paper: Any, computed: Any, unit: str = "") -> None:
        """One line; the difference is taken where both sides are numbers or equally long lists of numbers. `paper` is
        None where the paper does not say."""
        difference = None
        if _is_numeric(paper) and _is_numeric(computed) and np.shape(paper) == np.shape(computed):
            delta = np.asarray(computed, dtype=float) - np.asarray(paper, dtype=float)
            difference = delta.tolist()
        self.rows.append({"quantity": quantity, "paper": paper, "computed": computed, "difference": difference, "unit": unit})

    def erratum(self, text: str, *, shown: bool) -> None:
        """An error of the paper; `shown` is the computation's verdict, and a claim that fails stops the study."""
        if not shown:
            raise SystemExit(f"{self.name}: the computation does not show the erratum: {text}")
        self.errata.append(text)

    def finish(self, figure: Figure, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        picture, data = folder / f"{self.name}.png", folder / f"{self.name}.json"
        figure.savefig(picture, dpi=130)
        content = {"study": self.name, "title": self.title, "seed": self.seed, "rows": self.rows, "errata": self.errata}
        data.write_text(json.dumps(content, indent=1, default=_plain) + "\n")
        console = Console(width=150)
        table = Table("quantity", "paper", "computed", "difference", title=self.title, title_justify="left")
        for row in self.rows:
            unit = f" [{row['unit']}]" if row["unit"] else ""
            table.add_row(
                row["quantity"] + unit.replace("[", r"\["), *(_text(row[k]) for k in ("paper", "computed", "difference"))
            )
        console.print(table)
        for text in self.errata:
            console.print(f"Erratum, shown by computation: {text}", markup=False, highlight=False)
        if self.seed is not None:
            console.print(f"seed {self.seed}")
        console.print(f"written: {picture}, {data}", markup=False, highlight=False)


def options_parser(description: str | None, seed: int | None = None) -> ArgumentParser:
    """`-o`, and `--seed` where a study has one; a study adds its own options."""
    parser = ArgumentParser(description=description)
    parser.add_argument("-o", "--output", type=Path, default=Path("out"), help="folder for the PNG and the JSON (default: out)")
    if seed is not None:
        parser.add_argument("--seed", type=int, default=seed, help=f"seed of the random numbers (default: {seed})")
    return parser


def folder_from_arguments(description: str | None) -> Path:
    """The folder that `-o` names; default `out`."""
    folder: Path = options_parser(description).parse_args().output
    return folder


def new_figure(width: float, height: float) -> Figure:
    """A figure that needs no display."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def equal_axes(axes: Any, low: Sequence[float], high: Sequence[float], unit: str, step: float) -> None:
    """A 3-D picture of the box from `low` to `high` at equal scales, ticks at multiples of `step`, the unit on each axis."""
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(np.subtract(high, low), zoom=1.12)
    for axis, name, a, b in zip((axes.xaxis, axes.yaxis, axes.zaxis), "xyz", low, high, strict=True):
        axis.set_ticks(step * np.arange(np.ceil(a / step), np.floor(b / step) + 1))
        axis.set_label_text(f"{name} [{unit}]")
        axis.set_tick_params(labelsize=8, pad=0)
    axes.zaxis.set_rotate_label(False)
    axes.zaxis.label.set_rotation(90)


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
        return f"{value:.6g}"
    if isinstance(value, list | tuple | np.ndarray):
        return ", ".join(_text(v) for v in value)
    return str(value)
