"""Write source and header of one mechanism: choose which of the three kinds it is, and state its ranges and rules."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from textwrap import wrap
from typing import Any

from symkin.codegen.arm_speeds import arm_speeds_header
from symkin.codegen.c_emitter import Real
from symkin.codegen.c_templates import fill
from symkin.codegen.home_pose import home_pose
from symkin.codegen.limb_platform import LimbPlatform
from symkin.codegen.limb_platform_source import LimbPlatformSource
from symkin.codegen.newton_kernel import rounded
from symkin.codegen.newton_source import NewtonCode
from symkin.codegen.options import Options
from symkin.codegen.platform_rates import fastest
from symkin.codegen.rod_kernel import is_rod_platform
from symkin.codegen.rod_platform import RodPlatform
from symkin.codegen.rod_platform_source import RodSource
from symkin.codegen.serial_arm import ArmSource, SerialArm
from symkin.model.mechanism import Mechanism
from symkin.model.names import check_c_name, cmake_target
from symkin.text import c_comment

Kind = RodPlatform | LimbPlatform | SerialArm
_SOURCES: dict[type, Callable[[Any], RodSource | LimbPlatformSource | ArmSource]] = {
    SerialArm: ArmSource,
    RodPlatform: RodSource,
    LimbPlatform: LimbPlatformSource,
}


@dataclass(frozen=True, eq=False)
class Program:
    """Source and header of a mechanism, and what the other files of its folder are made from."""

    kind: Kind
    source: str
    header: str
    main: NewtonCode
    values: dict[str, object]

    @property
    def mechanism(self) -> Mechanism:
        return self.kind.mechanism

    @property
    def real(self) -> Real:
        return self.kind.real

    @property
    def options(self) -> Options:
        return self.kind.options


def build_program(mechanism: Mechanism, options: Options) -> Program:
    """Everything that is compiled, as text."""
    check_c_name(mechanism.name)
    options.check(mechanism)
    kind = _kind(mechanism, options)
    source = _SOURCES[type(kind)](kind)
    kind.check()
    if not isinstance(kind, RodPlatform):
        kind.geometry.check(kind.real)
    values = source.values | _header_values(kind, source.code)
    if mechanism.serial:
        values["speeds"] = arm_speeds_header(mechanism.characteristic_length, values)
    else:
        values["speeds"] = fill("platform_rates.h", values | {"fastest": f"{fastest(mechanism.characteristic_length):g}"})
    values["declarations"] = fill(f"{kind.templates}.h", values)
    return Program(
        kind=kind,
        source=fill("begin.c", values) + source.text.rstrip() + "\n",
        header=fill("header.h", values),
        main=source.code,
        values=values,
    )


def _kind(mechanism: Mechanism, options: Options) -> Kind:
    """Which of the three kinds a mechanism is."""
    real = Real(options.real, f"{mechanism.name}_real")
    if mechanism.serial:
        return SerialArm(mechanism, options, real)
    if is_rod_platform(mechanism):
        return RodPlatform(mechanism, options, home_pose(mechanism, options.home), real)
    return LimbPlatform(mechanism, options, real)


def _header_values(kind: Kind, main: NewtonCode) -> dict[str, object]:
    mechanism, real, options = kind.mechanism, kind.real, kind.options
    name = mechanism.name
    struct = options.geometry == "struct"
    relative = options.home_relative
    counts = ", ".join(f"{count} {what}" for what, count in main.operations.items())
    about = [
        *_range_lines(kind), "",
        "Joint values in this order; lengths in " + mechanism.length_unit + ", angles in radians.",
        *(["Joint values and positions are changes from home, orientations turns from home's, in base axes: "
           f"{name}_home is the pose of zeros."] if relative else []),
        "Calls keep no state, allocate nothing and end after a bounded number of steps. Results are written with",
        f"{name.upper()}_OK only; `info` always. config and info may be NULL, guess and pose the same object.",
        *_branch_lines(kind), "",
        f"One step of Newton's method: {counts} (rows, matrix, factors, step).",
        f"Predicted error of an answer: {name.upper()}_TOLERANCE and the rounding of the type, about",
        f"{_short(8 * real.epsilon * mechanism.characteristic_length)} {mechanism.length_unit} (angles times the size) where the matrix is well conditioned.",
        f"Model SHA-256 {mechanism.digest}",
    ]  # fmt: skip
    if relative:
        about[about.index("") + 2 : about.index("") + 3] = [
            "Joint values and positions are changes from home, orientations turns from home's (R = R_turn R_home), in base",
            "axes. Home: " + ", ".join(_short(float(v)) for v in [*kind.home.position, *kind.home.quaternion]) + ".",  # type: ignore[union-attr]
        ]
    return {
        "title": "\n * ".join(wrap(c_comment(mechanism.title), 110)) or name, "stamp": f"Generated by symkin, options: {options.arguments}. Do not edit.",
        "about": "\n".join((" * " + line).rstrip() for line in about), "ctype": real.name, "target": cmake_target(name), "unit": mechanism.length_unit,
        "of_track": "" if mechanism.serial else f" ({name}_track: predicted error of the pose)",
        # an error e leaves kappa e^2 after one more step
        "track_limit": real.literal(rounded(math.sqrt(main.tuning.tolerance) / main.tuning.kappa2**0.25)),
        "guess_precision": _guess_precision(kind),
        "frame": mechanism.frame_name,
        "relative": ", as changes from home" if relative else "",
        "size": real.literal(mechanism.characteristic_length), "tolerance": real.literal(main.tuning.tolerance), "max_step": real.literal(mechanism.characteristic_length),
        "geometry": _geometry(kind) if struct else "", "gpd": f"const {name}_geometry *geometry, " if struct else "",
    }  # fmt: skip


def _guess_precision(kind: Kind) -> str:
    """How well a guess must keep to what the platform can do, as words of a comment."""
    words = "The length of its quaternion may be off by a hundredth"
    if kind.mechanism.motion == "spatial":
        return f"{words}."
    off = _short(max(1e-6, 64 * kind.real.epsilon) * kind.mechanism.characteristic_length)
    return f"{words},\n * its pose off the platform's motion ({kind.mechanism.motion}) by {off} {kind.mechanism.length_unit} (angles times the size)."


def _short(value: float) -> str:
    return f"{value:.6g}"


def _range_lines(kind: Kind) -> list[str]:
    unit = kind.mechanism.length_unit
    lines = []
    for number, c in enumerate(kind.mechanism.actuated):
        span = f"[{c.limits[0]:.6g}, {c.limits[1]:.6g}]" if c.limits else "no limits given"
        lines.append(f"joints[{number}] {c_comment(c.name)}: {'rad' if c.is_angular else unit}, {span}")
    return lines


def _branch_lines(kind: Kind) -> list[str]:
    if not kind.has_dead_centres:
        return []
    return [
        "Limbs have the branches (elbow up or down) of the reference configuration, followed along the line of poses from",
        "there; the guess's passive joints are computed from its pose in this way. A dead centre of a limb is a singularity:",
        "where a limb has passed one, the direct problem answers with the status of a wrong branch.",
    ]


def _geometry(kind: Kind) -> str:
    """The struct of the geometry and its nominal values."""
    if not isinstance(kind, RodPlatform):
        return kind.geometry.declaration(kind.name, kind.real)
    name, real = kind.name, kind.real
    numbers = kind.geometry_values.reshape(6, 7)
    base = ", ".join("{ " + ", ".join(real.literal(float(v)) for v in row[:3]) + " }" for row in numbers)
    ends = ", ".join("{ " + ", ".join(real.literal(float(v)) for v in row[3:6]) + " }" for row in numbers)
    offsets = ", ".join(real.literal(float(row[6])) for row in numbers)
    return "\n".join([
        "/* Joint centres on the base (base frame) and on the platform (platform frame), and rod lengths at zero. */",
        "typedef struct {", f"    {name}_real base[6][3];", f"    {name}_real platform[6][3];", f"    {name}_real offset[6];", f"}} {name}_geometry;", "",
        "/* Nominal geometry, as an initialiser. */",
        f"#define {name.upper()}_NOMINAL \\", f"    {{ {{ {base} }}, \\", f"      {{ {ends} }}, \\", f"      {{ {offsets} }} }}", "",
    ])  # fmt: skip
