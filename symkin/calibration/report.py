"""Report a calibration to its user: a verdict with reasons, as a short text, JSON and Markdown."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from symkin.calibration.data.observables import is_angular
from symkin.calibration.data.parameters import MEASURING_FRAMES
from symkin.calibration.judge.euler_sequence import SequenceChoice
from symkin.calibration.judge.fit_notes import is_exact
from symkin.calibration.judge.holdout import HeldOut
from symkin.calibration.judge.identifiability import OPEN_LOOPS
from symkin.calibration.judge.plausibility import (
    describe_other_machine,
)
from symkin.calibration.judge.pose_accuracy import PoseSigma
from symkin.calibration.judge.result import Calibration, Parameter, unit_of, value_out
from symkin.calibration.judge.statistics import SIGNIFICANCE
from symkin.position.solution import finite
from symkin.text import markdown, markdown_block, markdown_code

_MAX_SHOWN = 6
"""Changes and outliers that the short text shows."""
_MAX_OUTSIDE_SHARE = 0.2
"""Share of the workspace's poses beyond the measured joint values that is worth a note."""


@dataclass(frozen=True, eq=False)
class FitReport:
    """A fit with what its user must know besides: where the data came from, the Euler sequence that
    was found, mistakes that may explain readings which do not fit, the pose's standard deviation,
    how far the geometry went from the file's, and why it is not to be used.
    """

    fit: Calibration
    data: str
    command: str
    sequence: SequenceChoice | None
    suspicions: tuple[str, ...]
    notes: tuple[str, ...]
    sigma: PoseSigma
    refusal: str | None = None
    held_out: HeldOut | None = None

    @property
    def usable(self) -> bool:
        """Whether the fit converged, every combination that moves poses was observable, and the
        readings fit the geometry (no `refusal`).
        """
        fit = self.fit
        return (
            fit.status == "ok"
            and fit.refused is None
            and not self._tells_too_little
            and bool(fit.used)
            and self.refusal is None
        )

    @property
    def _tells_too_little(self) -> bool:
        """Whether the readings leave open what moves poses, or tell nothing at all."""
        return self.sigma.blind or self.fit.rank == 0 or self.fit.identifiability.opens

    @property
    def sound(self) -> bool:
        """Whether nothing speaks against the fit."""
        return (
            self.usable
            and self.fit.sound
            and (self.held_out is None or self.held_out.believable)
            and not self.suspicions
            and (self.sequence is None or self.sequence.clear)
        )

    @property
    def tested(self) -> bool:
        """Whether the fit was tested: by the noise stated, or by postures held out."""
        return self.fit.tested or self._predicted > 0

    @property
    def _predicted(self) -> int:
        """How many postures were held out and predicted with a probability."""
        held = self.held_out
        return 0 if held is None or held.p_value is None else len(held.labels)

    @property
    def believable(self) -> bool:
        return self.sound and self.tested

    @property
    def verdict(self) -> str:
        """One sentence: believable, not tested, or why not."""
        if self.sound:
            other = f"; {describe_other_machine(self.fit)}" if self.fit.is_other_machine else ""
            if not self.tested:
                return (
                    f"NOT TESTED: converged; the noise is not known and no posture was held out, "
                    f"so that nothing says whether it is right: state standard deviations or take "
                    f"--hold-out 20%{other}"
                )
            sure = (
                "the residuals are as the stated noise lets expect"
                if self.fit.p_value is not None
                else "the noise is not known"
            )
            if not self._predicted:
                return f"believable: {sure}{other}"
            link = "and" if self.fit.p_value is not None else "but"
            return (
                f"believable: {sure}, {link} {self._predicted} held-out postures are "
                f"predicted as well as it lets expect{other}"
            )
        why = f"; {self.suspicions[0]}" if self.suspicions else ""
        if self.fit.status != "ok":
            return f"NOT USABLE: the fit did not converge ({self.fit.status}){why}"
        if self._tells_too_little:
            if self.fit.identifiability.opens:
                return f"NOT USABLE: {OPEN_LOOPS}{why}"
            return (
                f"NOT USABLE: the readings do not determine the geometry; see what is not "
                f"observable{why}"
            )
        if self.refusal is not None:
            return f"NOT USABLE: {self.refusal}{'' if why[2:] in self.refusal else why}"
        if self.fit.refused is not None:
            return f"NOT USABLE: {self.fit.refused}{why}"
        return "NOT BELIEVABLE: " + (self.suspicions[0] if self.suspicions else self._doubt())

    def _doubt(self) -> str:
        fit = self.fit
        if fit.degrees <= 0:
            return "no degree of freedom is left to check it; add postures"
        if fit.p_value is not None and is_exact(fit):
            return (
                "the residuals are rounding only, far below the stated noise: a plan, or a "
                "simulation without noise?"
            )
        if fit.p_value is not None and fit.p_value >= 1.0 - SIGNIFICANCE:
            return (
                f"chi-square per degree of freedom is only {fit.chi_square / fit.degrees:.3g}; the "
                f"stated noise is too large, and the "
                "standard deviations with it"
            )
        if fit.p_value is not None and fit.p_value <= SIGNIFICANCE:
            return (
                f"chi-square per degree of freedom is {fit.chi_square / fit.degrees:.3g}; noise "
                f"larger than stated, outliers, or a model that lacks something"
            )
        if fit.given_up:
            return "too many readings do not belong; see the notes"
        if fit.unsolved:
            return f"{len(fit.unsolved)} of {len(fit.measurements)} postures do not close"
        if self.held_out is not None and not self.held_out.believable:
            return self.held_out.doubt
        if self.sequence is not None and not self.sequence.clear:
            return "these data cannot tell the Euler sequence: several fit almost equally"
        return "see the notes"

    @property
    def all_notes(self) -> tuple[str, ...]:
        """All notes, those on the data first."""
        return (*self._sequence(), *self.suspicions, *self._beyond(), *self.notes, *self.fit.notes)

    def _sequence(self) -> tuple[str, ...]:
        """The Euler sequence that was found; not stated where the readings fit in none."""
        if self.sequence is None:
            return ()
        return (str(self.sequence) if self._fits else self.sequence.none_fits,)

    @property
    def _fits(self) -> bool:
        """Whether the readings fit some geometry, all of it observable or not."""
        return self.fit.status == "ok" and self.refusal is None

    def _beyond(self) -> tuple[str, ...]:
        """What is known of poses outside the measured configurations, where they are many."""
        sigma, m = self.sigma.about_home, self.fit.mechanism
        if sigma is None or not self.usable or np.mean(sigma.outside) <= _MAX_OUTSIDE_SHARE:
            return ()
        there, inside = (
            float(np.max(sigma.position[part], initial=0.0))
            for part in (sigma.outside, ~sigma.outside)
        )
        elsewhere = "" if np.all(sigma.outside) else f" and {inside:.3g} {m.length_unit} elsewhere"
        return (
            f"{int(np.sum(sigma.outside))} of {len(sigma.outside)} poses of the workspace about "
            f"home need joint values beyond those measured: the "
            f"largest standard deviation of the position is {there:.3g} {m.length_unit} "
            f"there{elsewhere}; "
            "no reading has tested the model there; measure as far as the mechanism is used",
        )

    def changes(self) -> list[Parameter]:
        """List the mechanism's parameters by the size of their change, angles times the size."""
        own = [p for p in self.fit.parameters if p.name not in MEASURING_FRAMES]
        return sorted(own, key=lambda p: -self.fit.relative_change(p))

    def measuring_frames(self) -> list[Parameter]:
        """List the frames between the mechanism and what was measured that were identified."""
        return [p for p in self.fit.parameters if p.name in MEASURING_FRAMES and not p.held]

    # --- text -------------------------------------------------------------------------------------

    def summary(self) -> str:
        """Write what the terminal shows."""
        fit, found = self.fit, self.fit.identifiability
        p = "" if fit.p_value is None else f", probability {fit.p_value:.3g}"
        lines = [
            f"{fit.mechanism.name}: {self.verdict}",
            f"  {fit.status} after {fit.iterations} iterations, {len(fit.used)} of "
            f"{len(fit.measurements)} postures, "
            f"chi-square {fit.chi_square:.4g} with {fit.degrees} degrees of freedom{p}",
            f"  rank {found.rank} of {len(found.names)} parameters, condition "
            f"{found.condition:.3g}",
        ]
        if self.fit.frames:
            lines.append(f"  frames held by the least change: {_short(self.fit.frames, 10)}")
        missing = "NOT OBSERVABLE" if self.sigma.blind else "not observable, moves no pose"
        lines += [f"  {missing}: {text}" for text in self.fit.unobservable[:_MAX_SHOWN]]
        if len(self.fit.unobservable) > _MAX_SHOWN:
            lines.append(
                f"  and {len(self.fit.unobservable) - _MAX_SHOWN} more combinations (report.md)"
            )
        if self.fit.unobservable:
            lines.append(
                f"  {len(found.base_set)} parameters are a base set, for --parameters (report.md)"
            )
        lines += [f"  to do: {text}" for text in found.advice]
        lines += ["  " + self.residual_text(), "  " + self.sigma_text()]
        lines += [f"  {text}" for text in self.held_out_texts()]
        lines.append(
            f"  the geometry's poses differ from the file's by "
            f"{100 * self.fit.departure.share:.2g} % of their spread (frames aligned)"
        )
        changed = [
            f"{q.name} {_value(self, q, q.change, sign=True)}" for q in self.changes()[:_MAX_SHOWN]
        ]
        if changed:
            lines.append(f"  largest changes: {', '.join(changed)}")
        if placed := [
            f"{q.name} {_out(self, q, q.value):.7g} {_unit(self, q)}"
            for q in self.measuring_frames()
        ]:
            lines.append(f"  measuring frames: {', '.join(placed)}")
        for o in fit.outliers[:_MAX_SHOWN]:
            lines.append(f"  outlier: {o.reason}")
        if len(fit.outliers) > _MAX_SHOWN:
            lines.append(f"  and {len(fit.outliers) - _MAX_SHOWN} more outliers (report.md)")
        said = {o.reason for o in fit.outliers} | set(found.advice)
        for note in self.all_notes:
            if not any(text in note for text in said) and not note.startswith("not observable"):
                lines.append(f"  note: {note}")
        return "\n".join(lines)

    def sigma_text(self) -> str:
        """Say what is known of poses after this fit; no figure where the fit is not usable."""
        m = self.fit.mechanism
        if not self.usable:
            return "standard deviation of poses: none, the fit is not usable"
        if self.fit.degrees <= 0 and self.fit.p_value is None:
            return "standard deviation of poses: unknown, no degree of freedom is left"
        stated = ""
        if (
            self.fit.p_value is not None
            and not SIGNIFICANCE < self.fit.p_value < 1.0 - SIGNIFICANCE
        ):
            times = math.sqrt(self.fit.chi_square / self.fit.degrees)
            stated = (
                f"; with the noise as stated, while the residuals are {times:.3g} times as large"
            )
        return (
            f"standard deviation of poses in aligned frames ({self.sigma.where}): rms "
            f"{_rms(self.sigma.position):.3g} {m.length_unit} and "
            f"{m.angle_out(_rms(self.sigma.angle)):.3g} {m.angle_unit}, largest "
            f"{self.sigma.position.max():.3g} {m.length_unit} and "
            f"{m.angle_out(float(self.sigma.angle.max())):.3g} {m.angle_unit}{stated}"
        )

    def residual_text(self) -> str:
        """Write the root mean square of the residuals of each kind."""
        by_kind = dict[str, list[float]]()
        for r in self.fit.residuals:
            by_kind.setdefault(r.kind, []).append(r.value)
        parts = []
        for kind, values in by_kind.items():
            rms = _rms(np.array(values))
            parts.append(f"{kind} {_of_kind(self, kind, rms):.3g} {_unit_of_kind(self, kind)}")
        return "residuals, rms: " + ", ".join(parts)

    def held_out_texts(self) -> list[str]:
        """Say how well held-out configurations are predicted; nothing where none were held out."""
        held = self.held_out
        if held is None:
            return []
        parts = [
            f"{kind} {_of_kind(self, kind, rms):.3g} (expected "
            f"{_of_kind(self, kind, held.expected[kind]):.3g}) {_unit_of_kind(self, kind)}"
            for kind, rms in held.rms.items()
        ]
        p = "" if held.p_value is None else f", probability {held.p_value:.3g}"
        lines = [
            f"held out, at random with seed {held.seed}: {len(held.labels)} postures, errors of "
            f"the prediction, rms: {', '.join(parts)}; "
            f"chi-square {held.chi_square:.4g} with {held.degrees} degrees of freedom{p}"
        ]
        if held.outliers:
            lines.append(
                f"held-out postures that are outliers, left out of that chi-square: "
                f"{_short(held.outliers, _MAX_SHOWN)}"
            )
        if held.unsolved:
            lines.append(
                f"held-out postures whose direct problem has no solution: "
                f"{_short(held.unsolved, _MAX_SHOWN)}"
            )
        return lines

    def to_dict(self, *, residuals: bool = True) -> dict[str, Any]:
        """Return the JSON object of the report, with or without `residuals`; lengths in the
        mechanism's unit, angles in its angle unit.
        """
        fit, m = self.fit, self.fit.mechanism
        return {
            "mechanism": m.name,
            "data": self.data,
            "command": self.command,
            "length_unit": m.length_unit,
            "angle_unit": m.angle_unit,
            "verdict": self.verdict,
            "believable": self.believable,
            "tested": self.tested,
            "usable": self.usable,
            **fit.figures(),
            "euler_sequence": None
            if self.sequence is None or not self._fits
            else {
                "sequence": self.sequence.sequence,
                "same": list(self.sequence.same),
                "chi_square": self.sequence.chi_square,
                "runner_up": self.sequence.runner_up,
                "runner_up_chi_square": finite(self.sequence.runner_up_chi_square),
                "clear": self.sequence.clear,
            },
            "departure": {
                "share": finite(self.fit.departure.share),
                "position": self.fit.departure.position,
                "angle": m.angle_out(self.fit.departure.angle),
                "open": self.fit.departure.unclosed,
                "postures": self.fit.departure.configurations,
            },
            **fit.findings(),
            "pose_sigma": None
            if not self.usable
            else {
                "where": self.sigma.where,
                "position_rms": _rms(self.sigma.position),
                "position_largest": float(self.sigma.position.max()),
                "angle_rms": m.angle_out(_rms(self.sigma.angle)),
                "angle_largest": m.angle_out(float(self.sigma.angle.max())),
            },
            "held_out": None
            if self.held_out is None
            else {
                "postures": list(self.held_out.labels),
                "seed": self.held_out.seed,
                "chi_square": self.held_out.chi_square,
                "degrees": self.held_out.degrees,
                "p_value": finite(self.held_out.p_value),
                "rms": {kind: _of_kind(self, kind, rms) for kind, rms in self.held_out.rms.items()},
                "expected_rms": {
                    kind: _of_kind(self, kind, rms) for kind, rms in self.held_out.expected.items()
                },
                "outliers": list(self.held_out.outliers),
                "unsolved": list(self.held_out.unsolved),
            },
            "suspicions": list(self.suspicions),
            "notes": list(self.all_notes),
            "elapsed_s": fit.elapsed_s,
            "residuals": list(fit.residual_rows()) if residuals else [],
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

    def to_markdown(self, files: Sequence[Path]) -> str:
        """Write the report; `files` are those that stand beside it, pictures among them."""
        fit, m = self.fit, self.fit.mechanism
        lines = [
            f"# Calibration of {m.name}",
            "",
            f"{markdown(self.verdict)}.",
            "",
            *markdown_block("text", self.summary()),
            "",
            f"Data: {markdown_code(self.data)}. Command:",
            "",
            *markdown_block("sh", self.command),
            "",
        ]
        lines += [f"![{f.stem.replace('_', ' ')}]({f.name})\n" for f in files if f.suffix == ".png"]
        lines += [
            "## Parameters",
            "",
            "| parameter | unit | nominal | identified | sigma | change |",
            "|---|---|---|---|---|---|",
        ]
        for q in fit.parameters:
            sigma = (
                "held"
                if q.held
                else "unknown"
                if q.sigma is None
                else f"{_out(self, q, q.sigma):.2g}"
            )
            lines.append(
                f"| {markdown(q.name)} | {_unit(self, q)} | {_out(self, q, q.nominal):.9g} | "
                f"{_out(self, q, q.value):.9g} | {sigma} | "
                f"{_out(self, q, q.change):+.3g} |"
            )
        lines += [
            "",
            "Parameters along what is not observable are held by the least change from nominal.",
            "",
        ]
        lines += ["## Observability", "", f"Rank {fit.rank} of {len(fit.identifiability.names)}."]
        lines += [f"- frame: {markdown(text)}" for text in self.fit.frames]
        lines += [f"- **not observable**: {markdown(text)}" for text in self.fit.unobservable]
        lines += [f"- to do: {markdown(text)}" for text in fit.identifiability.advice]
        if fit.identifiability.unobservable:
            names = ",".join(fit.identifiability.base_set)
            lines += [
                "",
                "A base set, which these readings tell whole where the other parameters are held:",
                "",
            ]
            lines += ["```text", f"--parameters {names}", "```"]
        lines += ["", "## Outliers", ""] + (
            [f"- {markdown(o.reason)}" for o in fit.outliers] or ["None."]
        )
        lines += ["", "## Notes", ""] + (
            [f"- {markdown(note)}" for note in self.all_notes] or ["None."]
        )
        return "\n".join(lines) + "\n"


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _of_kind(report: FitReport, kind: str, value: float) -> float:
    """A reading's value in the mechanism's unit."""
    return (
        report.fit.mechanism.angle_out(value) if is_angular(report.fit.mechanism, kind) else value
    )


def _unit_of_kind(report: FitReport, kind: str) -> str:
    m = report.fit.mechanism
    return m.angle_unit if is_angular(m, kind) else m.length_unit


def _unit(report: FitReport, q: Parameter) -> str:
    return unit_of(report.fit.mechanism, q) or "1"


def _out(report: FitReport, q: Parameter, value: float) -> float:
    return value_out(report.fit.mechanism, q, value)


def _value(report: FitReport, q: Parameter, value: float, *, sign: bool = False) -> str:
    unit = _unit(report, q)
    return f"{_out(report, q, value):{'+' if sign else ''}.3g}" + (
        "" if unit == "1" else f" {unit}"
    )


def _short(items: Sequence[str], most: int) -> str:
    return "; ".join(items[:most]) + (f" and {len(items) - most} more" if len(items) > most else "")
