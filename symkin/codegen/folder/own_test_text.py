"""Write the test of a generated folder from the signatures of its functions, and its vectors: every
problem is asked for its answers, and every function refuses each number that is not one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.codegen.folder.vectors import Vectors
from symkin.codegen.map.joint_map import JointMap
from symkin.codegen.map.program import Kind, Program
from symkin.codegen.map.signature import LINE, Function
from symkin.codegen.serial_arm import SerialArm
from symkin.codegen.text.c import Real, indent
from symkin.codegen.text.templates import fill, substitute
from symkin.model.joint import Coordinate

_COORDINATES = {"pose": "poses", "joints": "joints", "found": "found"}
"""Arguments that are a configuration, and labels of their vectors."""
_LIMITS = ("rate_limits", "joint_inertias", "joint_limits")
"""Arguments that are never below zero."""
_REFUSED = {
    "parallel": (
        "direct past OUT_OF_RANGE blamed",
        "direct singular SINGULAR guess",
        "inverse infeasible OUT_OF_RANGE",
        "direct doubled OUT_OF_RANGE guess",
        "inverse doubled OUT_OF_RANGE",
    ),
    "serial": (
        "direct past OUT_OF_RANGE",
        "inverse past OUT_OF_RANGE guess blamed line",
        "inverse singular SINGULAR guess",
        "inverse doubled OUT_OF_RANGE",
    ),
    "map": (
        "direct infeasible_joints OK",
        "inverse infeasible_found OK",
        "direct past_joints OUT_OF_RANGE blamed",
        "inverse past_found OUT_OF_RANGE",
    ),
}
"""Of each kind of machine: a problem, the label of values that it refuses, the status (OK: any
other one), and whether they are guesses, which joint is blamed is known, and lines are looked at.
"""
_TOO_FAR = 0.06
"""Way of the platform, in sizes, that is too long for one step of tracking."""
_NEAR_PATH = 0.01
"""How far (rad, or sizes) joints that a pose leaves free may be from the finely followed path."""
_NEAREST = 8.0
"""Times a vector's bound that formulas alone may be off."""


# --- vectors --------------------------------------------------------------------------------------


def vectors_text(program: Program, vectors: Vectors) -> str:
    """Write NAME_vectors.h: every number as a hexadecimal float, exactly as it is compared."""
    name, real, prefix = program.mechanism.name, program.real, program.mechanism.name.upper()
    lines = [
        f"/* Vectors for {name}_test.c, made by symkin's Python solvers; numbers are exact.",
        " * SPDX-License-Identifier: MIT */",
        f"#ifndef {prefix}_VECTORS_H",
        f"#define {prefix}_VECTORS_H",
        "",
        f'#include "{name}.h"',
        "",
        f"#define {prefix}_VECTORS {len(vectors.bounds)}",
        f"#define {prefix}_VECTOR_JACOBIANS {len(vectors.answers['jacobians'])}",
        *(
            f"#define {prefix}_VECTOR_{label.upper()} {len(rows)}"
            for label, rows in vectors.refused.items()
        ),
        "",
    ]
    for label, rows in (*vectors.answers.items(), *vectors.refused.items()):
        # an array of C has at least one row
        if len(rows):
            lines += _table(f"{name}_vector_{label}", rows, name, real)
    for label, row in vectors.places.items():
        lines.append(
            f"static const {name}_real {name}_vector_{label}[{len(row)}] = {{ {_row(row, real)} }};"
        )
    bounds = ", ".join(f"{float(v):.2g}" for v in vectors.bounds)
    return "\n".join(
        [
            *lines,
            "",
            "/* Error allowed, as a length. */",
            f"static const double {name}_vector_bounds[{len(vectors.bounds)}] = {{ {bounds} }};",
            "",
            "#endif",
            "",
        ]
    )


def _table(head: str, rows: np.ndarray, name: str, real: Real) -> list[str]:
    body = [f"    {{ {_row(row, real)} }}," for row in rows]
    shape = f"[{rows.shape[0]}][{rows.shape[1]}]"
    return [f"static const {name}_real {head}{shape} = {{", *body, "};", ""]


def _row(row: np.ndarray, real: Real) -> str:
    return ", ".join(real.hexadecimal(v) for v in row)


# --- functions ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Asked:
    """A function as the test asks for it: labels of its vectors, of what is not solved one row of
    `numbers`; weights that make lengths of differences, and how far answers may be off (`share` of
    a bound, and `within`).
    """

    function: Function
    values: str = ""
    guesses: str = ""
    answers: str = ""
    weights: Sequence[float] = ()
    step: str = "NULL"
    opposite: str = "NULL"
    blamed: int = 0
    few: int = 0
    share: float = 1.0
    within: float = 0.0
    numbers: str = ""

    @property
    def label(self) -> str:
        """What its row is called in C."""
        return f"of_{self.function.name}"

    def kinds(self, joints: int) -> str:
        """A letter for each number that is given or guessed."""
        letters = []
        for value in self.function.takes:
            is_place = value.name in _COORDINATES or value.name == "guess"
            kind = "c" if is_place else "l" if value.name in _LIMITS else "s"
            letters.append(kind * value.numbers(joints))
        return "".join(letters)

    def row(self, name: str, joints: int) -> list[str]:
        """Statements of its row."""
        function, tables = self.function, [self.values, self.guesses, self.answers]
        vectors = [f"&{name}_vector_{t}[0][0]" if t else "NULL" for t in tables]
        guessed = sum(v.numbers(joints) for v in function.takes if v.name == "guess")
        found = sum(v.numbers(joints) for v in function.gives)
        entries = [
            f'"{function.name}"',
            f"ask_{function.name}",
            f'"{self.kinds(joints)}"',
            len(self.kinds(joints)) - guessed,
            found,
            f"numbers_{self.label}" if self.numbers else vectors[0],
            *vectors[1:],
            f"weights_{self.label}" if self.weights else "NULL",
            self.step,
            self.opposite,
            self.blamed,
            self.few,
            repr(self.share),
            repr(self.within),
        ]
        weights = ", ".join(f"{float(w)!r}" for w in self.weights)
        arrays = {
            f"double weights_{self.label}": weights,
            f"{name}_real numbers_{self.label}": self.numbers,
        }
        return [
            *(f"static const {head}[] = {{ {text} }};" for head, text in arrays.items() if text),
            f"const function {self.label} = {{ {', '.join(map(str, entries))} }};",
        ]


def _pose_weights(size: float, of_turn: float) -> list[float]:
    return [1.0] * 3 + [of_turn * size] * 4


def _joint_weights(coordinates: Sequence[Coordinate], of_angle: float) -> list[float]:
    return [of_angle if c.is_angular else 1.0 for c in coordinates]


def _problems(program: Program) -> list[_Asked]:
    """The problems of a kind of machine."""
    kind, size = program.kind, program.mechanism.characteristic_length
    functions = {f.name: f for f in program.functions}
    direct, inverse = functions["direct"], functions["inverse"]
    if isinstance(kind, JointMap):
        found, given = (_joint_weights(part, size) for part in (kind.found, kind.given))
        step, back = "ask_track", "ask_track_inverse"
        return [
            _Asked(direct, "joints", "guesses", "found", found, step, blamed=1),
            _Asked(inverse, "found", "joint_guesses", "inverse", given, back),
        ]
    joints = _joint_weights(program.mechanism.actuated, 0.5 * size)
    if not isinstance(kind, SerialArm):
        pose, few = _pose_weights(size, 2.0), int(not kind.is_closed)
        return [
            _Asked(direct, "joints", "guesses", "poses", pose, "ask_track", blamed=1, few=few),
            _Asked(inverse, "poses", answers="inverse", weights=joints),
        ]
    pose = _pose_weights(size, 1.0)
    asked = [_Asked(direct, "joints", answers="poses", weights=pose)]
    follow = _Asked(inverse, "poses", "guesses", "inverse", joints, "ask_track", blamed=2)
    if kind.is_redundant:
        weights = [1.0 if c.is_angular else 1.0 / size for c in program.mechanism.actuated]
        follow = replace(
            follow, weights=weights, opposite="&of_direct", share=0.0, within=_NEAR_PATH
        )
    asked.append(follow)
    if "inverse_nearest" in functions:
        nearest = functions["inverse_nearest"]
        asked.append(_Asked(nearest, "poses", "guesses", "inverse", joints, share=_NEAREST))
    return asked


def _numbers(function: Function, vectors: Vectors, real: Real, joints: int) -> str:
    """The first vector's configuration, and ones for all other numbers that a function takes."""
    numbers = list[float]()
    for value in function.takes:
        label = _COORDINATES.get(value.name)
        ones = np.ones(value.numbers(joints))
        numbers += (ones if label is None else vectors.answers[label][0]).tolist()
    return ", ".join(map(real.hexadecimal, numbers))


def _call(function: Function, joints: int, *, struct: bool) -> str:
    """Write the function of plain numbers that calls one of C: results that are poses begin as the
    result's numbers are, and may be the guess.
    """
    lines, arguments = [], ["config"] if function.config else []
    if struct:
        lines.append("const name_geometry nominal = NAME_NOMINAL;")
        arguments = ["&nominal", *arguments]
    place = {"given": 0, "result": 0}
    poses = list[str]()
    for value, array in (
        *((v, "guess" if v.name == "guess" else "given") for v in function.takes),
        *((v, "result") for v in function.gives),
    ):
        at = f"&{array}[{place[array]}]" if place.get(array) else array
        if value.count == "number":
            at = "0U"
        elif not value.count:
            lines.append(f"name_pose {array}_pose = pose_from({at});")
            at = f"&{array}_pose"
            poses.append(array)
        arguments.append(at)
        place[array] = place.get(array, 0) + value.numbers(joints)
    if {"guess", "result"} <= set(poses):
        arguments = [
            "(guess == result) ? &result_pose : &guess_pose" if a == "&guess_pose" else a
            for a in arguments
        ]
    arguments += ["info"] if function.info else []
    unused = {"config": function.config, "guess": "guess" in place, "info": function.info}
    body = [
        *lines,
        *(f"(void){name};" for name, used in unused.items() if not used),
        f"const name_status status = name_{function.name}({', '.join(arguments)});",
        *(["numbers_of(&result_pose, result);"] if "result" in poses else []),
        "return status;",
    ]
    head = (
        f"static name_status ask_{function.name}(const name_config *config, const name_real "
        f"*given, const name_real *guess, name_real *result, name_info *info)"
    )
    return f"{head}\n{{\n{indent(body)}\n}}\n"


# --- the test -------------------------------------------------------------------------------------


def own_test_text(program: Program, vectors: Vectors) -> str:
    """Write NAME_test.c."""
    kind, problems, name = program.kind, _problems(program), program.mechanism.name
    joints = len(kind.given if isinstance(kind, JointMap) else program.mechanism.actuated)
    solved = (*(p.function for p in problems), LINE)
    others = [f for f in program.functions if f not in solved and not f.moves]
    asked = [
        *problems,
        *(_Asked(f, numbers=_numbers(f, vectors, program.real, joints)) for f in others),
    ]
    values = program.values | _values(program)
    struct = program.options.geometry == "struct"
    called = [f for f in program.functions if f != LINE]
    each, alone, more = _own_checks(program, values)
    tables = [line for one in asked for line in one.row(name, joints)]
    list_of_all = ", ".join(f"&{one.label}" for one in asked)
    calls = [
        f"const function *const all[] = {{ {list_of_all} }};",
        f"for (int i = 0; i < {len(asked)}; ++i) {{",
        "    if (all[i]->answers != NULL) {",
        "        solve_all(all[i]);",
        "    }",
        "    refuse_values(all[i]);",
        "}",
        f"for (int k = 0; k < {name.upper()}_VECTOR_JACOBIANS; ++k) {{",
        *(f"    {check}" for check in each),
        "}",
        *alone,
    ]
    rows = _refused_rows(program, vectors)
    return fill(
        "test.c",
        values
        | {
            "poses": "" if isinstance(kind, JointMap) else fill("pose_numbers.c", values),
            "wrappers": substitute(
                "\n".join(_call(f, joints, struct=struct) for f in called), values
            ),
            "tables": tables,
            "calls": [*calls, *rows],
            "refuse_rows": fill("refuse_rows.c", values) if rows else "",
            "feasible": fill("feasible_rates.c", values) if "feasible" in vectors.answers else "",
            "more": more,
        },
    )


def _own_checks(program: Program, values: Mapping[str, object]) -> tuple[list[str], list[str], str]:
    """What a kind of machine is asked beside problems and refusals: calls for each case that has a
    Jacobian, calls that are made once, and the functions.
    """
    kind = program.kind
    if isinstance(kind, JointMap):
        each = ["jacobian_of(k);", "derivatives_of(k);"]
        return each, [], fill("map_derivatives_test.c", values)
    each, speeds = ["jacobian_of(k);", "speeds_of(k);"], fill("speeds_test.c", values)
    if not isinstance(kind, SerialArm) or kind.plan is None:
        return each, [], speeds
    size, epsilon = program.mechanism.characteristic_length, program.real.epsilon
    closed = {
        "angular": ", ".join(str(int(c.is_angular)) for c in program.mechanism.actuated),
        "reached": f"{4 * program.main.tuning.tolerance + 512 * epsilon * size:.2g}",
    }
    alone = [
        f"for (int k = 0; k < {program.mechanism.name.upper()}_VECTORS; ++k) {{",
        "    branches_of(&of_direct, k);",
        "}",
    ]
    return each, alone, speeds + fill("closed_test.c", {**values, **closed})


def _values(program: Program) -> dict[str, object]:
    """Names of the test's templates."""
    kind, name, real = program.kind, program.mechanism.name, program.real
    size, is_float = program.mechanism.characteristic_length, real.name == "float"
    compared = [
        "for (int i = 0; i < N; ++i) {",
        "    const double off = fabs((double)again[i] - (double)rates[i]);",
        f"    expect(off <= {'1e-3' if is_float else '1e-9'} * ({_speed_unit(program)}), "
        '"rates of the twist of rates", i);',
        "}",
    ]
    # an arm's are damped, and the shortest
    exact = not isinstance(kind, SerialArm)
    of_map = isinstance(kind, JointMap)
    largest = 1.0 if of_map else max(1.0, size, 1.0 / size)
    configuration, read = "&pose", [f"const {name}_pose pose = pose_from({name}_vector_poses[k]);"]
    if not exact:
        configuration, read = f"{name}_vector_joints[k]", []
    elif of_map:
        configuration = "joints, found"
        read = [
            f"const {name}_real *const {label} = {name}_vector_{label}[k];"
            for label in ("joints", "found")
        ]
    return {
        "most": "(N * N * N + N * N + 7)" if of_map else "(6 * N + 13)",
        "far": real.literal(1e4 * max(size, 1.0)),
        "configuration": configuration,
        "configuration_of_k": read,
        "nominal": nominal(program),
        "no_info": "" if exact else ", NULL",
        "entries": "N * N" if of_map else "6 * N",
        "jacobian_most": f"{(1e-4 if is_float else 1e-8) * largest:.6g}",
        "jacobian_bound": "1e-4" if is_float else "1e-8",
        "speed_unit": "" if of_map else _speed_unit(program),
        "speeds_law": "Rates of the twist of rates are these rates." if exact else "",
        "speeds_compared": compared if exact else "",
    }


def nominal(program: Program) -> str:
    """Write the statements that give a call the nominal geometry, where it asks for one."""
    name = program.mechanism.name
    return (
        f"    const {name}_geometry nominal = {name.upper()}_NOMINAL;\n"
        f"    const {name}_geometry *const geometry = &nominal;"
        if program.options.geometry == "struct"
        else ""
    )


def _speed_unit(program: Program) -> str:
    """What a joint's rates are told in, C text by the joint's number `i`: sizes or radians."""
    slides = [f"(i == {i})" for i, c in enumerate(program.mechanism.actuated) if not c.is_angular]
    size = f"(double){program.mechanism.name.upper()}_SIZE"
    if len(slides) == len(program.mechanism.actuated):
        return size
    return f"({' || '.join(slides)}) ? {size} : 1.0" if slides else "1.0"


def _refused_rows(program: Program, vectors: Vectors) -> list[str]:
    """Statements that ask for what no configuration has, what is beyond limits and what is
    singular.
    """
    kind, name, lines = program.kind, program.mechanism.name, list[str]()
    for row in _REFUSED[kind.templates]:
        problem, label, status, *flags = row.split()
        count = len(vectors.refused[label])
        if count and not ("line" in flags and not _follows_formulas(kind)):
            blamed = "blamed" if "blamed" in flags else "NULL"
            lines.append(
                f"refuse_rows(&of_{problem}, &{name}_vector_{label}[0][0], {count}, "
                f"{int('guess' in flags)}, {name.upper()}_{status}, {blamed});"
            )
    if any(", blamed);" in line for line in lines):
        told = ", ".join(map(str, vectors.blamed))
        lines = [f"static const int blamed[] = {{ {told} }};", *lines]
    far = vectors.places.get("far")
    if far is not None and not kind.is_closed:
        away = np.linalg.norm(far[:3] - vectors.answers["poses"][0][:3])
        if away > _TOO_FAR * program.mechanism.characteristic_length:
            lines.append(
                f"refuse(&of_direct, ask_track, {name}_vector_joints[0], {name}_vector_far, "
                f"{name.upper()}_WRONG_BRANCH, -1, 0);"
            )
    return lines


def _follows_formulas(kind: Kind) -> bool:
    """Whether an arm's limits are looked at along the line, and not at the answer alone."""
    return isinstance(kind, SerialArm) and kind.follows_closed_form
