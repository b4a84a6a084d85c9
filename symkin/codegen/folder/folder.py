"""Write the folder of one mechanism: sources, test, build files, README and manifest; the same
model gives the same bytes. What package managers of microcontrollers read stands beside the
sources; answers of the machine that a description means are held against the description itself.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Unpack

import casadi as ca
import numpy as np

from symkin._version import __version__
from symkin.codegen.folder.cpp_header import cpp_text
from symkin.codegen.folder.example import example_text
from symkin.codegen.folder.linuxcnc import linuxcnc_text
from symkin.codegen.folder.own_test import run_own_test
from symkin.codegen.folder.own_test_text import nominal, own_test_text, vectors_text
from symkin.codegen.folder.readme import readme
from symkin.codegen.folder.ros2 import ros2_files
from symkin.codegen.folder.vectors import Vectors, build_vectors
from symkin.codegen.map.firmware_options import FirmwareOptions
from symkin.codegen.map.joint_map import JointMap
from symkin.codegen.map.options import Options
from symkin.codegen.map.program import Program, build_program
from symkin.codegen.serial_arm import SerialArm
from symkin.codegen.text.templates import fill
from symkin.codegen.text.width import narrowed
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
from symkin.position.given import read_given
from symkin.position.problem import build_problem
from symkin.position.solve import solve
from symkin.spatial.pose import Pose
from symkin.verb import verb

_KEY = "model_sha256"
"""What the manifest of a folder of firmware has, and others have not."""


@verb(FirmwareOptions)
def write_firmware(
    mechanism: Mechanism, directory: Path | str, **options: Unpack[FirmwareOptions]
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
    return write_folder(mechanism, Path(directory), Options.of(options))


def write_folder(
    mechanism: Mechanism, folder: Path, options: Options, measured: Mapping[str, Any] | None = None
) -> list[Path]:
    """Write the folder, a new one where it is missing, and return its files; `measured`: figures of
    codegen/measured.json.

    Raises InputError where that would replace a file that is not symkin's, is another mechanism's,
    or was edited, and where a compiler finds that the code fails its own test.
    """
    if not options.is_map:
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
    vectors = build_vectors(kind)
    check_description(program, vectors)
    name = program.mechanism.name
    values = program.values | _folder_values(program)
    files = {
        f"{name}.h": program.header,
        f"{name}.c": program.source,
        f"{name}_test.c": own_test_text(program, vectors),
        f"{name}_vectors.h": vectors_text(program, vectors),
        "example_main.c": example_text(kind.templates, values),
        "CMakeLists.txt": fill("CMakeLists.txt", values),
        "Makefile": fill("Makefile", values),
        "README.md": readme(program),
    }
    files |= package_files(program.mechanism, values) if "package" in options.also else {}
    if "linuxcnc" in options.also:
        files[f"{name}_kins.c"] = linuxcnc_text(program, vectors.places.get("home"))
    files |= {f"{name}.hpp": cpp_text(program)} if "cpp" in options.also else {}
    files |= (
        ros2_files(kind, values) if "ros2" in options.also and isinstance(kind, JointMap) else {}
    )
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


def _folder_values(program: Program) -> dict[str, object]:
    """Names of the templates of examples, packages and build files."""
    name = program.mechanism.name
    struct = program.options.geometry == "struct"
    return {
        "nominal": nominal(program),
        "gpe": f"const {name}_geometry *geometry, " if struct else "",
        "version": ".".join(re.findall(r"[0-9]+", __version__)[:3]),
        "installed": f"{name}.h" + (f" {name}.hpp" if "cpp" in program.options.also else ""),
    }


# --- package --------------------------------------------------------------------------------------


_URL = "https://pypi.org/project/symkin"
_LONGEST = 80
"""Characters of the sentence that a library manager shows in a line."""


def package_files(mechanism: Mechanism, values: Mapping[str, object]) -> dict[str, str]:
    """Text of each file by its name. Arduino compiles `src/` alone, so that test and example stay
    out; PlatformIO and Zephyr name the source.
    """
    name = mechanism.name
    shown = {**values, "sentence": _sentence(mechanism), "url": _URL}
    templates = {
        "library.json": "library.json",
        "library.properties": "library.properties",
        f"src/{name}.h": "arduino.h",
        f"src/{name}.c": "arduino.c",
        "zephyr/module.yml": "module.yml",
        "zephyr/CMakeLists.txt": "zephyr.cmake",
        "zephyr/Kconfig": "Kconfig",
    }
    return {file: fill(template, shown) for file, template in templates.items()}


def _sentence(mechanism: Mechanism) -> str:
    """The title as one line that JSON, properties and Kconfig all take."""
    title = re.sub(r"""[^ -~]|["'\\$=]""", " ", mechanism.title or "")
    return " ".join(f"Kinematics of {mechanism.name} {title}".split())[:_LONGEST].rstrip()


# --- what it is written for -----------------------------------------------------------------------


_JUDGED = 4
"""Vectors of which the description is asked: enough to tell another machine."""


def check_description(program: Program, vectors: Vectors) -> None:
    """Raises InputError where the described machine, from the pose of a vector, does not come to
    rest at that pose with the vector's joint values.
    """
    described, size = program.described, program.described.characteristic_length
    if described == program.lowered:
        return
    answers = vectors.answers
    rows = zip(answers["joints"], answers["poses"], vectors.bounds, strict=True)
    for joints, pose, bound in list(rows)[:_JUDGED]:
        given = {
            c.name: described.angle_out(value) if c.is_angular else value
            for c, value in zip(described.actuated, joints.tolist(), strict=True)
        }
        there = Pose(pose[:3], pose[3:])
        # the pose of a chain of driven joints is no matter of a start
        problem = build_problem(described, read_given(described, given).names)
        start = None if problem.is_explicit else there
        found = solve(described, joints=given, start=start, check=False).solution
        away = np.inf if found is None else _distance(found.pose, there, size)
        if not away <= bound:
            raise InputError(
                f"{described.name}: at {given} the described machine is {away:.3g} "
                f"{described.length_unit} from where its generated code is; write its links as "
                f"limbs and declare its motion"
            )


def _distance(pose: Pose, other: Pose, size: float) -> float:
    """How far poses are apart, turns times the size."""
    away = pose.inverse() @ other
    turn = 2.0 * float(np.linalg.norm(away.quaternion[1:]))
    return float(np.linalg.norm(away.position)) + size * turn
