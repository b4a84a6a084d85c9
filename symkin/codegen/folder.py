"""Write the folder of one mechanism: sources, test, build files, README and manifest; the same
model gives the same bytes.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import casadi as ca
import numpy as np

from symkin._version import __version__
from symkin.codegen.cpp_header import cpp_text
from symkin.codegen.described import check_description
from symkin.codegen.joint_map import JointMap
from symkin.codegen.joint_map_vectors import MapVectors
from symkin.codegen.linuxcnc import linuxcnc_text
from symkin.codegen.options import Options
from symkin.codegen.own_test import run_own_test
from symkin.codegen.package import package_files
from symkin.codegen.program import Program, build_program, is_closed
from symkin.codegen.readme import readme
from symkin.codegen.ros2 import ros2_files
from symkin.codegen.serial_arm import SerialArm
from symkin.codegen.text.c import Real, indent
from symkin.codegen.text.templates import fill
from symkin.codegen.text.width import narrowed
from symkin.codegen.vectors import Vectors, build_vectors
from symkin.errors import InputError
from symkin.files.outputs import write_output
from symkin.files.written_files import (
    MANIFEST,
    digest,
    foreign_files,
    read_manifest,
    refuse_foreign,
)
from symkin.model.arm import arm_of
from symkin.model.mechanism import Mechanism, require_mechanism
from symkin.verb import verb

_KEY = "model_sha256"
"""What the manifest of a folder of firmware has, and others have not."""


@verb
def write_firmware(
    mechanism: Mechanism,
    directory: Path | str,
    *,
    real: Literal["float", "double"] = "double",
    home_relative: bool = False,
    geometry: Literal["fixed", "struct"] = "fixed",
    home: Sequence[float] | None = None,
    given: Sequence[str] = (),
    find: Sequence[str] = (),
    also: Collection[Literal["package", "linuxcnc", "cpp", "ros2"]] = (),
    compact: bool = False,
) -> list[Path]:
    """Write C99 for controllers into a folder and return its files: direct and inverse kinematics,
    Jacobian, test, build files.

    `real` is the C type of numbers, "double" by default, or "float"; `home_relative` makes joint
    values and positions changes from home; `geometry` "struct" gives the numbers of the geometry
    with each call in place of the code; `home` is the pose x, y, z, qw, qx, qy, qz (length unit)
    about which pivots are chosen. `home_relative` and `home` are for platforms on six rods. `given`
    and `find` name joint coordinates, as many of each as the mobility: the code is then the map
    from one to the other and back, of any mechanism, graphs and files of robots too, with Jacobian,
    rates and torques. `also` asks for more files: "package" (PlatformIO, Arduino, Zephyr),
    "linuxcnc" (a kinematics component), "cpp" (a header for C++17), "ros2" (of a map: a package
    with a transmission of ros2_control). `compact` asks for the least code, at some cost of
    instructions. Where a C compiler is at hand the code's own test is
    compiled and run first. Raises InputError for a mechanism that no code can be written for,
    options that do not fit it, code that fails its own test, and a folder that holds files of
    somebody else.

    >>> import symkin, tempfile
    >>> arm = symkin.load("gluon_6l3")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.suffix for path in symkin.write_firmware(arm, folder, real="float")][:3]
    ['.h', '.c', '.c']
    """
    require_mechanism(mechanism)
    pose = None if home is None else tuple(float(v) for v in home)
    chosen = Options(
        real, home_relative, geometry, pose, tuple(given), tuple(find), tuple(also), compact
    )
    return write_folder(mechanism, Path(directory), chosen)


def write_folder(
    mechanism: Mechanism, folder: Path, options: Options, measured: Mapping[str, Any] | None = None
) -> list[Path]:
    """Write the folder, a new one where it is missing, and return its files; `measured`: figures of
    codegen/measured.json.

    Raises InputError where that would replace a file that is not symkin's, is another mechanism's,
    or was edited, and where a compiler finds that the code fails its own test.
    """
    if not options.is_map and mechanism.is_graph:
        mechanism = arm_of(mechanism) or mechanism
    check_folder(mechanism, folder)
    files = folder_files(mechanism, options, measured)
    run_own_test(mechanism.name, files)
    try:
        _check_files(folder, files)
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (folder / name).parent.mkdir(exist_ok=True)
            write_output(folder / name, text)
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be written ({error.strerror}); give a folder with -o"
        ) from None
    return [folder / name for name in files]


def check_folder(mechanism: Mechanism, folder: Path) -> None:
    """Raise InputError where the folder is a file or has the code of another mechanism."""
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; the name of a folder is needed")
    written = read_manifest(folder, _KEY)
    if written.get("mechanism", mechanism.name) != mechanism.name:
        raise InputError(
            f"{folder}: holds the code of {written['mechanism']!r}; give another folder with -o"
        )


def _check_files(folder: Path, files: dict[str, str]) -> None:
    """Raise InputError for files in the way that are neither as the folder's manifest says they
    were written nor as they are to be, as after a run that was cut short.
    """
    written = read_manifest(folder, _KEY)
    digests = {
        name: (written.get("files", {}).get(name), digest(text.encode()))
        for name, text in files.items()
    }
    names = [name for name in files if name != MANIFEST or not written]
    remedy = "move them away, or give another folder with -o"
    refuse_foreign(folder, foreign_files(folder, names, digests), written.get("files", {}), remedy)


def folder_files(
    mechanism: Mechanism, options: Options, measured: Mapping[str, Any] | None = None
) -> dict[str, str]:
    """Write the text of each file, by its name."""
    program = build_program(mechanism, options, measured)
    kind = program.kind
    vectors = MapVectors(kind) if isinstance(kind, JointMap) else build_vectors(kind)
    if not isinstance(vectors, MapVectors):
        check_description(program, vectors)
    name = program.mechanism.name
    values = program.values | _test_values(program)
    values |= _closed_values(program, values)
    templates = program.kind.templates
    files = {
        f"{name}.h": program.header,
        f"{name}.c": program.source,
        f"{name}_test.c": fill(f"{templates}_test.c", values),
        f"{name}_vectors.h": vectors.text()
        if isinstance(vectors, MapVectors)
        else vectors_text(program, vectors),
        "example_main.c": fill(f"{templates}_example.c", values),
        "CMakeLists.txt": fill("CMakeLists.txt", values),
        "Makefile": fill("Makefile", values),
        "README.md": readme(program),
    }
    files |= package_files(program.mechanism, values) if options.package else {}
    if options.linuxcnc and not isinstance(vectors, MapVectors):
        files[f"{name}_kins.c"] = linuxcnc_text(program, vectors.home)
    files |= {f"{name}.hpp": cpp_text(program)} if options.cpp else {}
    files |= ros2_files(kind, values) if options.ros2 and isinstance(kind, JointMap) else {}
    files = {
        file: narrowed(text) if file.endswith((".c", ".h", ".hpp")) else text
        for file, text in files.items()
    }
    files[MANIFEST] = manifest(program, files)
    return files


def manifest(program: Program, files: dict[str, str]) -> str:
    """Write versions, options, model and file digests: what decides the bytes."""
    options = program.options
    content = {
        "mechanism": program.mechanism.name,
        "model_sha256": program.described.digest,
        "symkin": __version__,
        "casadi": ca.__version__,
        "options": {
            "real": options.real,
            "home_relative": options.home_relative,
            "geometry": options.geometry,
            "home": options.home,
            **({"given": options.given, "find": options.find} if options.is_map else {}),
            **({"compact": True} if options.compact else {}),
            **{str(name): True for name in options.also},
        },
        "operations_per_iteration": program.main.operations,
        "worst_case": program.worst.manifest(),
        **_closed_manifest(program),
        "files": {name: digest(text.encode()) for name, text in sorted(files.items())},
    }
    return json.dumps(content, indent=2) + "\n"


def _closed_manifest(program: Program) -> dict[str, object]:
    """List the choices of an arm's closed form and its steps."""
    kind = program.kind
    if not isinstance(kind, SerialArm) or kind.plan is None:
        return {}
    return {
        "closed_form": {
            "choices": list(kind.plan[0].branches),
            "steps": kind.plan[0].derivation(),
            "nearly": kind.plan[1],
        }
    }


def _test_values(program: Program) -> dict[str, object]:
    real, mechanism = program.real, program.mechanism
    struct = program.options.geometry == "struct"
    name, length = mechanism.name, mechanism.characteristic_length
    nominal = (
        f"    const {name}_geometry nominal = {name.upper()}_NOMINAL;\n"
        f"    const {name}_geometry *const geometry = &nominal;"
        if struct
        else ""
    )
    return (
        _redundant_values(program)
        | _map_values(program)
        | {
            "far": real.literal(1e4 * max(length, 1.0)),
            "angle_bound": _angle_bound(program),
            "jacobian_unit": f"{max(1.0, length, 1.0 / length)!r}",
            "jacobian_bound": "1e-4" if real.name == "float" else "1e-8",
            "nominal": nominal,
            **_one_step_values(program),
            "gpe": f"const {name}_geometry *geometry, " if struct else "",
            "version": ".".join(re.findall(r"[0-9]+", __version__)[:3]),
            "installed": f"{name}.h" + (f" {name}.hpp" if program.options.cpp else ""),
            "speed_unit": _speed_unit(program),
            "speed_bound": "1e-3" if real.name == "float" else "1e-9",
            "tolerance_text": f"{program.main.tuning.tolerance:.2g}",
            "closed_test": "",
            "closed_call": "",
        }
    )


def _one_step_values(program: Program) -> dict[str, object]:
    """Write the test that one step from home is not enough, for a direct problem that is
    iterated.
    """
    if is_closed(program.kind):
        return {"one_step": "", "one_step_is_few": ""}
    prefix, few = program.mechanism.name, f"{program.mechanism.name.upper()}_MAX_ITERATIONS"
    sizes = f"{prefix.upper()}_TOLERANCE, 1U, {prefix.upper()}_MAX_STEP"
    return {
        "one_step": f"    const {prefix}_config one_step = {{ {sizes} }};",
        "one_step_is_few": (
            f'    expect(refused(&one_step, joints, &home, "one step is not enough") == {few}, '
            f'"MAX_ITERATIONS", 0);'
        ),
    }


def _closed_values(program: Program, values: dict[str, object]) -> dict[str, object]:
    """Write the test of an arm's closed form."""
    kind = program.kind
    if not isinstance(kind, SerialArm) or kind.plan is None:
        return {}
    size, epsilon = program.mechanism.characteristic_length, program.real.epsilon
    own = {
        "angular": ", ".join(str(int(c.is_angular)) for c in program.mechanism.actuated),
        "reached": f"{4 * program.main.tuning.tolerance + 512 * epsilon * size:.2g}",
    }
    return {
        "closed_test": fill("closed_test.c", values | own),
        "closed_call": "    closed_form();\n    closed_refusals();",
    }


def _map_values(program: Program) -> dict[str, object]:
    """Give the weights that turn differences of a map's values into lengths."""
    kind = program.kind
    if not isinstance(kind, JointMap):
        return {}
    parts = {"joint_weights": kind.given, "found_weights": kind.found}
    return {
        key: ", ".join(f"{kind.size if c.is_angular else 1.0!r}" for c in part)
        for key, part in parts.items()
    }


def _angle_bound(program: Program) -> str:
    """What makes the allowed error of lengths one of joint value `i`, which may be an angle."""
    if not any(c.is_angular for c in program.mechanism.actuated):
        return ""
    slides, weight = _slides(program), f"{2.0 / program.mechanism.characteristic_length!r}"
    return f" * (({slides}) ? 1.0 : {weight})" if slides else f" * {weight}"


def _speed_unit(program: Program) -> str:
    """What a joint's rates are told in, C text by the joint's number `i`: sizes or radians."""
    slides, size = _slides(program), f"(double){program.mechanism.name.upper()}_SIZE"
    every = not any(c.is_angular for c in program.mechanism.actuated)
    return size if every else f"({slides}) ? {size} : 1.0" if slides else "1.0"


def _slides(program: Program) -> str:
    """C condition: joint `i` is a length. Empty where none is."""
    return " || ".join(
        f"(i == {i})" for i, c in enumerate(program.mechanism.actuated) if not c.is_angular
    )


def _redundant_values(program: Program) -> dict[str, object]:
    """Say how answers of a serial arm are compared: joint by joint; where a pose leaves joints
    free, near the end of the finely followed path, and exactly by the tool's pose.
    """
    kind, name = program.kind, program.mechanism.name
    if not kind.is_redundant:
        return {"joint_bound": "bound" + _angle_bound(program), "again": ""}
    slides = _slides(program)
    bound = (
        f"(({slides}) ? {0.01 * program.mechanism.characteristic_length!r} : 0.01)"
        if slides
        else "0.01"
    )
    first = "geometry, " if program.options.geometry == "struct" else ""
    again = [
        f'expect({name}_direct({first}joints, &pose) == {name.upper()}_OK, "direct of the '
        f'answer", k);',
        "for (int i = 0; i < 3; ++i) {",
        f"    expect(fabs((double)pose.position[i] - (double){name}_vector_poses[k][i]) <= bound, "
        f'"the answer\'s position", k);',
        "}",
        "for (int i = 0; i < 4; ++i) {",
        f"    const double off = fabs((double)pose.quaternion[i] - "
        f"(double){name}_vector_poses[k][3 + i]);",
        f'    expect((double){name.upper()}_SIZE * off <= bound, "the answer\'s quaternion", k);',
        "}",
    ]
    return {"joint_bound": bound, "again": indent(again, 2)}


def vectors_text(program: Program, vectors: Vectors) -> str:
    """Write NAME_vectors.h: every number as a hexadecimal float, exactly as it is compared."""
    name, real = program.mechanism.name, program.real
    kind = f"{name}_real"
    far = _far(vectors)
    tables = [
        ("guesses", vectors.guesses),
        ("joints", vectors.joints),
        ("poses", vectors.poses),
        ("inverse", vectors.inverse),
        ("jacobians", vectors.jacobians),
    ]
    lines = [
        f"/* Vectors for {name}_test.c, made by symkin's Python solvers; numbers are exact.",
        " * SPDX-License-Identifier: MIT */",
        f"#ifndef {name.upper()}_VECTORS_H",
        f"#define {name.upper()}_VECTORS_H",
        "",
        f'#include "{name}.h"',
        "",
        f"#define {name.upper()}_VECTORS {len(vectors.joints)}",
        f"#define {name.upper()}_VECTOR_JACOBIANS {len(vectors.jacobians)}",
        f"#define {name.upper()}_VECTOR_SINGULAR {len(vectors.singular)}",
        f"#define {name.upper()}_VECTOR_INFEASIBLE {len(vectors.infeasible)}",
        f"#define {name.upper()}_VECTOR_PAST {len(vectors.past)}",
        f"#define {name.upper()}_VECTOR_FAR {int(_is_too_far(program, far, vectors))}",
        "",
    ]
    for label, table in tables:
        lines += _table(f"{kind} {name}_vector_{label}", table, real)
    if len(vectors.infeasible):
        lines += _table(f"{kind} {name}_vector_infeasible", vectors.infeasible, real)
    if len(vectors.past):
        lines += _table(f"{kind} {name}_vector_past", vectors.past, real)
        lines.append(
            f"static const int {name}_vector_blamed[{len(vectors.blamed)}] = {{ "
            f"{', '.join(map(str, vectors.blamed))} }};"
        )
    if len(vectors.singular):
        lines += _table(f"{kind} {name}_vector_singular", vectors.singular, real)
    if not isinstance(program.kind, SerialArm):
        for label, row in (("home", vectors.home), ("far", far)):
            lines.append(
                f"static const {kind} {name}_vector_{label}[7] = {{ "
                f"{', '.join(real.hexadecimal(float(v)) for v in row)} }};"
            )
    bounds = ", ".join(f"{float(v):.2g}" for v in vectors.bounds)
    lines += [
        "",
        "/* Error allowed, as a length. */",
        f"static const double {name}_vector_bounds[{len(vectors.bounds)}] = {{ {bounds} }};",
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def _is_too_far(program: Program, far: np.ndarray, vectors: Vectors) -> bool:
    """Tell whether one step of tracking cannot bring the platform there: formulas can."""
    away = np.linalg.norm(far[:3] - vectors.poses[0][:3])
    return not is_closed(program.kind) and bool(
        away > 0.06 * program.mechanism.characteristic_length
    )


def _table(head: str, table: np.ndarray, real: Real) -> list[str]:
    rows = [f"    {{ {', '.join(real.hexadecimal(float(v)) for v in row)} }}," for row in table]
    return [f"static const {head}[{table.shape[0]}][{table.shape[1]}] = {{", *rows, "};", ""]


def _far(vectors: Vectors) -> np.ndarray:
    """Find the pose farthest from the first vector's: too long a step for tracking."""
    return np.asarray(
        vectors.poses[
            int(np.argmax(np.linalg.norm(vectors.poses[:, :3] - vectors.poses[0][:3], axis=1)))
        ]
    )
