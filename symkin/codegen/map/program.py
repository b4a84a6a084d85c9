"""Write source and header of one mechanism: choose which of the three kinds it is, and state its
ranges and rules.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

from symkin.codegen.arm_speeds import DAMPED_BELOW, MOST_TURN
from symkin.codegen.map.home_pose import home_pose
from symkin.codegen.map.implied_platform import limb_platform
from symkin.codegen.map.joint_map import JointMap
from symkin.codegen.map.joint_map_source import JointMapSource
from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.map.limb_platform_source import LimbPlatformSource
from symkin.codegen.map.options import Options
from symkin.codegen.map.platform_rates import fastest
from symkin.codegen.map.rod_platform import RodPlatform
from symkin.codegen.map.rod_platform_source import RodSource
from symkin.codegen.map.signature import Function, declarations
from symkin.codegen.serial_arm import ArmSource, SerialArm
from symkin.codegen.steps.formula_guards import feasible_error
from symkin.codegen.steps.geometry import geometry_check
from symkin.codegen.steps.guard_text import Watched
from symkin.codegen.steps.newton_kernel import rounded
from symkin.codegen.steps.newton_source import NewtonCode, tracked_error
from symkin.codegen.steps.rod_kernel import is_rod_platform
from symkin.codegen.text.c import Real
from symkin.codegen.text.templates import fill
from symkin.codegen.worst_case import WorstCase
from symkin.errors import InputError
from symkin.machine.limbs import with_limbs
from symkin.machine.lower import Lowered, lowered_limbs
from symkin.model.mechanism import Mechanism
from symkin.model.names import check_c_name, cmake_target
from symkin.model.oddities import degrees_question
from symkin.text import c_comment

Kind = LimbPlatform | SerialArm | JointMap
_SOURCES: dict[type, Callable[[Any], Any]] = {
    SerialArm: ArmSource,
    RodPlatform: RodSource,
    LimbPlatform: LimbPlatformSource,
    JointMap: JointMapSource,
}


@dataclass(frozen=True)
class SmallestSize:
    """From which size on code holds, and why: what of a smaller machine is no normal number."""

    value: float
    what: str

    @staticmethod
    def of(kind: Kind) -> SmallestSize:
        """Formulas of arms hold fourth powers of lengths, as what is derived in double does, whose
        roundings have to be normal numbers; all other code squares of roundings of lengths.
        """
        real = kind.real
        if real.name == "double" or (isinstance(kind, SerialArm) and kind.plan is not None):
            what = "roundings of fourth powers of lengths"
            return SmallestSize((real.least / real.epsilon) ** 0.25, what)
        return SmallestSize(real.least**0.5 / real.epsilon, "squares of roundings of lengths")

    def check(self, kind: Kind) -> None:
        """Raises InputError for a machine that is smaller."""
        size, unit, real = kind.size, kind.mechanism.length_unit, kind.real.name
        if size < self.value:
            remedy = "--real double has smaller numbers, or " if real == "float" else ""
            raise InputError(
                f"{kind.name}: its size, the largest distance of joint points at the reference, is "
                f"{size:.3g} {unit}; code in {real} holds from {self.value:.3g} {unit} on, because "
                f"{self.what} are below the least normal {real}; {remedy}tell lengths in a "
                "smaller unit"
            )


@dataclass(frozen=True, eq=False)
class Program:
    """Source and header of a mechanism, and what the other files of its folder are made from.
    `lowered` is the machine that the `described` one means; the kind's may be of a declared motion
    where that one's is implied. `watched` is what each function with lines watches on them.
    """

    described: Mechanism
    lowered: Mechanism
    kind: Kind
    source: str
    header: str
    main: NewtonCode
    watched: Mapping[str, Watched]
    functions: tuple[Function, ...]
    values: dict[str, object]
    worst: WorstCase
    smallest: SmallestSize

    @property
    def mechanism(self) -> Mechanism:
        return self.kind.mechanism

    @property
    def real(self) -> Real:
        return self.kind.real

    @property
    def options(self) -> Options:
        return self.kind.options


def build_program(
    mechanism: Mechanism, options: Options, measured: Mapping[str, Any] | None = None
) -> Program:
    """Everything that is compiled, as text; `measured`: figures of a processor, stated where they
    are those of this code.
    """
    low = _lowered(mechanism, options)
    check_c_name(low.machine.name)
    options.check(low.machine)
    described, kind = low.written, _kind(low, options)
    if options.compact and not kind.can_be_compact:
        raise InputError(
            f"{mechanism.name}: its code has nothing that --compact would shorten (it replaces an "
            f"unrolled factorisation of Newton's "
            "method by loops); leave --compact out"
        )
    smallest = SmallestSize.of(kind)
    smallest.check(kind)
    source = _SOURCES[type(kind)](kind)
    kind.check()
    kind.geometry.check(kind.real)
    begin = fill("begin.c", source.values | _header_values(kind, source.code, [], described.digest))
    body = source.text.rstrip() + "\n"
    lu = fill("lu.c", source.values) if f"{kind.name}_lu(" in body else ""
    checks = geometry_check(kind.geometry)
    text = kind.real.typed(begin + checks + lu + body, kind.name, struct=bool(kind.geometry.names))
    worst = WorstCase.of(kind.name, text, measured)
    values = source.values | _header_values(
        kind, source.code, worst.header_lines(), described.digest
    )
    values["declarations"] = declarations(kind.functions, values)
    return Program(
        described=described,
        lowered=low.machine,
        kind=kind,
        source=text,
        header=fill("header.h", values),
        main=source.code,
        watched=source.watched,
        functions=kind.functions,
        values=values,
        worst=worst,
        smallest=smallest,
    )


def _lowered(mechanism: Mechanism, options: Options) -> Lowered:
    """The machine to write code for: a map between joints, an arm, and numbers that are given with
    each call are of the machine as it is described.
    """
    if options.is_map:
        return Lowered(mechanism, mechanism)
    remedy = (
        "describe the machine by limbs, or map joints to joints by --given and --find (given and "
        "find in Python)"
    )
    limbs = with_limbs(mechanism, "firmware", remedy)
    if limbs.serial or options.geometry == "struct":
        return Lowered(limbs, limbs)
    return lowered_limbs(mechanism)


def _kind(low: Lowered, options: Options) -> Kind:
    """Which of the three kinds a machine is."""
    mechanism = low.machine
    real = Real(options.real, f"{mechanism.name}_real")
    if options.is_map:
        return JointMap(mechanism, options, real)
    if mechanism.serial:
        return SerialArm(mechanism, options, real)
    if is_rod_platform(mechanism):
        return RodPlatform(mechanism, options, real, home=home_pose(mechanism, options.home))
    return limb_platform(mechanism, options, real, low.frames)


def _header_values(
    kind: Kind, main: NewtonCode, worst: list[str], digest: str
) -> dict[str, object]:
    mechanism, real, options = kind.mechanism, kind.real, kind.options
    name = mechanism.name
    struct = options.geometry == "struct"
    counts = ", ".join(f"{count} {what}" for what, count in main.operations.items())
    question = degrees_question(mechanism)
    about = [
        *_range_lines(kind),
        "",
        "Joint values in this order; lengths in " + mechanism.length_unit + ", angles in radians.",
        *([] if question is None else ["", *wrap(c_comment(f"Note: {question}"), 95), ""]),
        *kind.about_values,
        "Calls keep no state, allocate nothing and end after a bounded number of steps. Results "
        "are written with",
        f"{name.upper()}_OK only; `info` always. config and info may be NULL; each other "
        "result may lie where an input other than config lies.",
        *_branch_lines(kind),
        "",
        *_effort_lines(kind, counts),
        f"Predicted error of an answer: {name.upper()}_TOLERANCE and the rounding of the type, "
        f"about",
        f"{_short(8 * real.epsilon * kind.size)} {mechanism.length_unit} "
        f"(angles times the size) where the matrix is well conditioned.",
        *worst,
        "",
        f"Model SHA-256 {digest}",
    ]
    return {
        "title": "\n * ".join(wrap(c_comment(mechanism.title), 110)) or name,
        "stamp": c_comment(f"Generated by symkin, options: {options.arguments}. Do not edit."),
        "about": "\n".join((" * " + line).rstrip() for line in about),
        "ctype": real.name,
        "target": cmake_target(name),
        "unit": mechanism.length_unit,
        "of_track": _of_track(kind),
        "track_limit": real.literal(rounded(tracked_error(main.tuning, kind.size))),
        "guess_precision": _guess_precision(kind) if kind.of_poses else "",
        "pose_type": _pose_type(kind) if kind.of_poses else "",
        "track_words": _track_words(kind) if kind.of_poses else "",
        "fastest_text": f"{fastest(kind.size):g}",
        "left_out": _left_out(kind) if kind.of_poses else "",
        "damped_below": DAMPED_BELOW,
        "most_turn": MOST_TURN,
        "pivot_words": _PIVOT_OF_FORMULAS if kind.is_closed else _PIVOT,
        "size": real.literal(kind.size),
        "tolerance": real.literal(main.tuning.tolerance),
        "max_step": real.literal(kind.size),
        "geometry": kind.geometry.declaration(name, real) if struct else "",
        "gpd": f"const {name}_geometry *geometry, " if struct else "",
    }


def _of_track(kind: Kind) -> str:
    """What the residual of one step is, as words of a comment."""
    if kind.templates == "serial" or kind.is_closed:
        return ""
    what = "the pose" if kind.of_poses else "a step of Newton's method"
    return f" ({kind.name}_track: predicted error of {what})"


def _pose_type(kind: Kind) -> str:
    """The type of poses."""
    relative = ", as changes from home" if kind.options.home_relative else ""
    values = {
        "p": kind.name,
        "unit": kind.mechanism.length_unit,
        "frame": kind.mechanism.frame_name,
        "relative": relative,
    }
    return "\n" + fill("pose_type.h", values)


def _effort_lines(kind: Kind, counts: str) -> list[str]:
    """What an iteration is and takes."""
    if not kind.is_closed:
        return [f"One step of Newton's method: {counts} (rows, matrix, factors, step)."]
    return [
        "Formulas give the direct problem: an iteration is one evaluation of them, at the end of "
        "a part of the line. Of a",
        "config max_step is not read; tolerance is what the closure's rows of the answer may "
        "leave beside rounding.",
    ]


_PIVOT = (
    "length of the last step; min_pivot: smallest pivot of the last matrix with rows and columns "
    "scaled,\n * 0 near a singularity"
)
_PIVOT_OF_FORMULAS = (
    "0; min_pivot: smallest root of the answer's formulas over its usual size,\n"
    " * 0 near a singularity"
)


def _track_words(kind: Kind) -> str:
    """What the header says of tracking."""
    prefix = kind.mechanism.name
    if kind.is_closed:
        return (
            "the formulas once, for a line that need not be cut: else WRONG_BRANCH, and call "
            f"{prefix}_direct. info->residual is the answer's closure error, beyond "
            f"{prefix.upper()}_TRACK_LIMIT near a singularity."
        )
    return (
        f"one step from the last pose; info->residual is the predicted error. Up to "
        f"{prefix.upper()}_TRACK_LIMIT another call "
        f"with the same joints brings it below the tolerance; beyond it, call {prefix}_direct."
    )


def _guess_precision(kind: Kind) -> str:
    """How well a guess must keep to what the platform can do, as words of a comment."""
    words = "The length of its quaternion may be off by a hundredth"
    if kind.mechanism.motion == "spatial":
        return f"{words}."
    off = _short(feasible_error(kind.real.epsilon, kind.size))
    motion, unit = kind.mechanism.motion, kind.mechanism.length_unit
    return (
        f"{words}, "
        f"its pose off the platform's motion ({motion}) by {off} {unit} (angles times the size)."
    )


def _left_out(kind: Kind) -> str:
    """What of a twist the platform cannot take, as words of a comment."""
    motion = kind.mechanism.motion
    return (
        ""
        if motion == "spatial"
        else f" The platform's motion is {motion}: what else a twist has it cannot take, and is "
        "left out."
    )


def _short(value: float) -> str:
    return f"{value:.6g}"


def _range_lines(kind: Kind) -> list[str]:
    unit, lines = kind.mechanism.length_unit, []
    for what, coordinates in kind.told.items():
        for number, c in enumerate(coordinates):
            span = f"[{c.limits[0]:.6g}, {c.limits[1]:.6g}]" if c.limits else "no limits given"
            lines.append(
                f"{what}[{number}] {c_comment(c.name)}: {'rad' if c.is_angular else unit}, {span}"
            )
    return lines


def _branch_lines(kind: Kind) -> list[str]:
    if not kind.has_dead_centres:
        return []
    return [
        "Limbs have the branches (elbow up or down) of the reference configuration, followed "
        "along the line of poses from",
        "there; the guess's passive joints are computed from its pose in this way. A dead centre "
        "of a limb is a singularity:",
        "where a limb has passed one, the direct problem answers with the status of a wrong "
        "branch.",
    ]
