"""Report a calibration to its user: a verdict with reasons, as a short text, JSON and Markdown."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from symkin.calibration.data.observables import measure_of, unit_of, value_out, written
from symkin.calibration.data.parameters import MEASURING_FRAMES
from symkin.calibration.judge.result import Parameter, length_and_angle
from symkin.calibration.judge.statistics import SIGNIFICANCE
from symkin.calibration.judge.verdict import Verdict
from symkin.position.solution import finite
from symkin.text import first_of, markdown, markdown_block, markdown_code

_MAX_SHOWN = 6
"""Changes and outliers that the short text shows."""


@dataclass(frozen=True, eq=False)
class FitReport(Verdict):
    """The verdict on the fit of a file, where the data came from, and what was run."""

    data: str
    command: str

    # --- text -------------------------------------------------------------------------------------

    def summary(self) -> str:
        """Write what the terminal shows."""
        notes, fit = self.all_notes, self.fit
        said = {o.reason for o in fit.outliers} | set(fit.identifiability.advice)
        share = 100 * fit.departure.share
        lines = [
            *self._figures(),
            self.residual_text(),
            self.sigma_text(),
            *self.held_out_texts(),
            f"the geometry's poses differ from the file's by {share:.2g} % of their spread (frames "
            f"aligned)",
            *self._changes(),
        ]
        lines += _some([f"outlier: {o.reason}" for o in fit.outliers], "outliers")
        lines += [
            f"note: {note}"
            for note in notes
            if not note.startswith("not observable") and not any(text in note for text in said)
        ]
        return "\n  ".join([f"{fit.mechanism.name}: {self.verdict}", *lines])

    def _figures(self) -> Iterator[str]:
        fit, found = self.fit, self.fit.identifiability
        p = "" if fit.p_value is None else f", probability {fit.p_value:.3g}"
        yield (
            f"{fit.status} after {fit.iterations} iterations, {len(fit.used)} of "
            f"{len(fit.measurements)} postures, chi-square {fit.chi_square:.4g} with {fit.degrees} "
            f"degrees of freedom{p}"
        )
        yield (
            f"rank {found.rank} of {len(found.names)} parameters, condition {found.condition:.3g}"
        )
        if fit.frames:
            yield f"frames held by the least change: {first_of(fit.frames, 10, '; ')}"
        missing = "NOT OBSERVABLE" if self.sigma.blind else "not observable, moves no pose"
        yield from _some([f"{missing}: {text}" for text in fit.unobservable], "combinations")
        if fit.unobservable:
            yield (f"{len(found.base_set)} parameters are a base set, for --parameters (report.md)")
        yield from (f"to do: {text}" for text in found.advice)

    def _changes(self) -> Iterator[str]:
        frames = [
            f"{p.name} {written(self.fit.mechanism, p.kind, p.value, '.7g')}"
            for p in self.fit.parameters
            if p.name in MEASURING_FRAMES and not p.held
        ]
        if changes := self.fit.largest_changes(_MAX_SHOWN):
            yield f"largest changes: {changes}"
        if frames:
            yield f"measuring frames: {', '.join(frames)}"

    def sigma_text(self) -> str:
        """Say what is known of poses after this fit; no figure where the fit is not usable."""
        fit, sigma = self.fit, self.sigma
        if not self.usable:
            return "standard deviation of poses: none, the fit is not usable"
        if fit.degrees <= 0 and fit.p_value is None:
            return "standard deviation of poses: unknown, no degree of freedom is left"
        stated = ""
        if fit.p_value is not None and not SIGNIFICANCE < fit.p_value < 1.0 - SIGNIFICANCE:
            times = math.sqrt(fit.chi_square / fit.degrees)
            stated = (
                f"; with the noise as stated, while the residuals are {times:.3g} times as large"
            )
        rms, largest = (
            length_and_angle(fit.mechanism, of(sigma.position), of(sigma.angle))
            for of in (_rms, np.max)
        )
        return (
            f"standard deviation of poses in aligned frames ({sigma.where}): rms {rms}, largest "
            f"{largest}{stated}"
        )

    def residual_text(self) -> str:
        """Write the root mean square of the residuals of each kind."""
        by_kind = dict[str, list[float]]()
        for r in self.fit.residuals:
            by_kind.setdefault(r.kind, []).append(r.value)
        m = self.fit.mechanism
        parts = [
            f"{kind} {written(m, measure_of(m, kind), _rms(np.array(values)), '.3g')}"
            for kind, values in by_kind.items()
        ]
        return "residuals, rms: " + ", ".join(parts)

    def held_out_texts(self) -> list[str]:
        """Say how well held-out configurations are predicted; nothing where none were held out."""
        held, m = self.held_out, self.fit.mechanism
        if held is None:
            return []
        parts = [
            f"{kind} {self._out(kind, rms):.3g} (expected "
            f"{self._out(kind, held.expected[kind]):.3g}) {unit_of(m, measure_of(m, kind))}"
            for kind, rms in held.rms.items()
        ]
        p = "" if held.p_value is None else f", probability {held.p_value:.3g}"
        told = (
            f"errors of the prediction, rms: {', '.join(parts)}; chi-square "
            f"{held.chi_square:.4g} with {held.degrees} degrees of freedom{p}"
        )
        return [
            f"held out, at random with seed {held.seed}: {len(held.labels)} postures, "
            f"{told if parts else 'none predicted'}",
            *(
                f"held-out postures {what}: {first_of(labels, _MAX_SHOWN, '; ')}"
                for what, labels in (
                    ("that are outliers, left out of that chi-square", held.outliers),
                    ("whose direct problem has no solution", held.unsolved),
                )
                if labels
            ),
        ]

    def _out(self, kind: str, value: float) -> float:
        """Convert a reading's value to the mechanism's unit."""
        return value_out(self.fit.mechanism, measure_of(self.fit.mechanism, kind), value)

    # --- JSON -------------------------------------------------------------------------------------

    def to_dict(self, *, residuals: bool = True) -> dict[str, Any]:
        """Return the JSON object of the report, with or without `residuals`; lengths in the
        mechanism's unit, angles in its angle unit.
        """
        fit, m, sigma, departure = self.fit, self.fit.mechanism, self.sigma, self.fit.departure
        sequence = self.sequence if self.fits else None
        pose_sigma = {
            "where": sigma.where,
            "position_rms": _rms(sigma.position),
            "position_largest": float(sigma.position.max()),
            "angle_rms": m.angle_out(_rms(sigma.angle)),
            "angle_largest": m.angle_out(float(sigma.angle.max())),
        }
        own = fit.to_dict(residuals=residuals)
        rows = own.pop("residuals")  # stand last
        return {
            **own,
            **{
                key: getattr(self, key)
                for key in ("data", "command", "verdict", "believable", "tested", "usable")
            },
            "euler_sequence": None if sequence is None else sequence.to_dict(),
            "departure": {
                "share": finite(departure.share),
                "position": departure.position,
                "angle": m.angle_out(departure.angle),
                "open": departure.unclosed,
                "postures": departure.configurations,
            },
            "pose_sigma": pose_sigma if self.usable else None,
            "held_out": self._held_out_dict(),
            "suspicions": list(self.suspicions),
            "notes": list(self.all_notes),
            "residuals": rows,
        }

    def _held_out_dict(self) -> dict[str, Any] | None:
        if (held := self.held_out) is None:
            return None
        return {
            "postures": list(held.labels),
            **{key: getattr(held, key) for key in ("seed", "chi_square", "degrees")},
            "p_value": finite(held.p_value),
            **{
                key: {kind: self._out(kind, rms) for kind, rms in of.items()}
                for key, of in (("rms", held.rms), ("expected_rms", held.expected))
            },
            "outliers": list(held.outliers),
            "unsolved": list(held.unsolved),
        }

    def json_text(self) -> bytes:
        """Write `to_dict` as a file's content, residuals a line each: objects of many
        configurations would take more memory than all else.
        """
        head = json.dumps(self.to_dict(residuals=False), indent=1, allow_nan=False)
        begin, _, end = head.rpartition("[]")
        rows = b",\n  ".join(
            json.dumps(row, allow_nan=False).encode() for row in self.fit.residual_rows()
        )
        return begin.encode() + b"[\n  " + rows + b"\n ]" + end.encode() + b"\n"

    # --- Markdown ---------------------------------------------------------------------------------

    def to_markdown(self, files: Sequence[Path]) -> str:
        """Write the report; `files` are those that stand beside it, pictures among them."""
        fit, found = self.fit, self.fit.identifiability
        base_set = [
            "\nA base set, which these readings tell whole where the other parameters are held:\n",
            *markdown_block("text", f"--parameters {','.join(found.base_set)}"),
        ]
        lines = [
            f"# Calibration of {fit.mechanism.name}\n",
            f"{markdown(self.verdict)}.\n",
            *markdown_block("text", self.summary()),
            f"\nData: {markdown_code(self.data)}. Command:\n",
            *markdown_block("sh", self.command),
            "",
            *(f"![{f.stem.replace('_', ' ')}]({f.name})\n" for f in files if f.suffix == ".png"),
            "## Parameters\n",
            "| parameter | unit | nominal | identified | sigma | change |",
            "|---|---|---|---|---|---|",
            *(self._row(q) for q in fit.parameters),
            "\nParameters along what is not observable are held by the least change from "
            "nominal.\n",
            f"## Observability\n\nRank {fit.rank} of {len(found.names)}.",
            *_items("frame: ", fit.frames),
            *_items("**not observable**: ", fit.unobservable),
            *_items("to do: ", found.advice),
            *(base_set if found.unobservable else ()),
            "\n## Outliers\n",
            *(_items("", [o.reason for o in fit.outliers]) or ["None."]),
            "\n## Notes\n",
            *(_items("", self.all_notes) or ["None."]),
        ]
        return "\n".join(lines) + "\n"

    def _row(self, q: Parameter) -> str:
        name, value, sigma, unit, change = self.fit.row(q)
        nominal = f"{value_out(self.fit.mechanism, q.kind, q.nominal):.9g}"
        return f"| {' | '.join((markdown(name), unit or '1', nominal, value, sigma, change))} |"


def _items(head: str, texts: Sequence[str]) -> list[str]:
    return [f"- {head}{markdown(text)}" for text in texts]


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _some(lines: Sequence[str], what: str) -> list[str]:
    """The first lines, and how many more there are."""
    more = len(lines) - _MAX_SHOWN
    return [*lines[:_MAX_SHOWN], *([f"and {more} more {what} (report.md)"] if more > 0 else [])]
