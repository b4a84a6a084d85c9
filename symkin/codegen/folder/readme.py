"""Write the README.md of a generated folder: how to use it, the equations that it solves, and what
is proved of its answers. Its words stand in templates/readme.md, chapter by chapter.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from symkin.codegen.map.implied_platform import CONFIGURATIONS
from symkin.codegen.map.joint_map import Direction, JointMap
from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.map.program import Program
from symkin.codegen.map.rod_platform import RodPlatform
from symkin.codegen.serial_arm import SerialArm
from symkin.codegen.steps.composed import Part
from symkin.codegen.steps.guard_text import bend_words, guard_tables
from symkin.codegen.text.latex import equations
from symkin.codegen.text.templates import substitute, template_text
from symkin.computed_once import lru_cache
from symkin.model.file import shipped
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.model.oddities import degrees_question
from symkin.model.shipped import shipped_names
from symkin.text import markdown

_LIBM = (
    " (with the same libm: its sin and cos differ from one library to another in the last bit,\n"
    "and results with them)"
)
_OF_FILE = " (`MECH`: the file that describes the machine, with the options by which it was read)"
_SIGN = r", or the sign of $\det J$ (free with the pivots) has changed where one ends"


def readme(program: Program) -> str:
    """Markdown with the equations in LaTeX."""
    mechanism, main, known = program.mechanism, program.main, _is_shipped(program.mechanism)
    question = degrees_question(mechanism)
    counts = "; ".join(f"{what}: {count}" for what, count in main.operations.items())
    is_one = program.kind.is_closed
    sines = bool(main.operations.get("sin"))
    return _words(
        "frame",
        p=mechanism.name,
        title=markdown(mechanism.title) or "generated kinematics",
        described=mechanism.name if known else "MECH",
        of_file="" if known else _OF_FILE,
        arguments=program.options.arguments,
        unit=mechanism.length_unit,
        trigonometry="sin and cos, " if sines else "",
        libm=_LIBM if sines else "",
        asked="" if question is None else f"\n\n**Note**: {markdown(question)}",
        source=markdown(mechanism.source) or "not given",
        step="One evaluation of formulas for each part of the line"
        if is_one
        else f"One step: {counts}",
        tolerance=f"{main.tuning.tolerance:.2g}",
        worst=program.worst.chapter(),
        chapters="\n\n".join(_chapters(program)),
        closure=equations(mechanism),
        digest=program.described.digest,
    )


@lru_cache(maxsize=1)
def _texts() -> dict[str, str]:
    """Words of each chapter."""
    _, *parts = re.split(r"<!-- (\w+) -->\n", template_text("readme.md"))
    return dict(zip(parts[::2], parts[1::2], strict=True))


def _words(chapter: str, **values: object) -> str:
    """A chapter's words, but for the last end of a line."""
    text = _texts()[chapter]
    return substitute(text, values) if chapter == "frame" else substitute(text, values).rstrip()


def _is_shipped(mechanism: Mechanism) -> bool:
    """Whether a command takes the name; of a file's mechanism, which may have the same name, it
    takes the path.
    """
    if mechanism.name not in shipped_names():
        return False
    ours = shipped(mechanism.name)
    return (ours.title, ours.source) == (mechanism.title, mechanism.source)


def _chapters(program: Program) -> list[str]:
    kind, guards = program.kind, guard_tables(program.mechanism.name, program.watched)
    if isinstance(kind, JointMap):
        return [_of_map(kind), _map_answers(program, kind), guards]
    if isinstance(kind, SerialArm):
        answers = (
            _words("closed_line", p=kind.name) if kind.follows_closed_form else _newton(program)
        )
        more = ["\n\n" + _words("redundant")] if kind.is_redundant else []
        return ["".join([_words("serial"), *more]), answers, guards, *_closed_form(kind)]
    if isinstance(kind, RodPlatform):
        more = ["\n" + _words("relative")] if program.options.home_relative else []
        return ["".join([_words("rods"), *more]), _newton(program), guards]
    solved = _words("solved" if kind.is_closed else "iterated")
    ok = [_newton(program)]
    if kind.direct_formulas is not None:
        ok = _direct_formulas(kind, implied=kind.mechanism.motion != program.lowered.motion)
    return [_words("closed", solved=solved), *_pose_rows(kind), *_limbs(kind), *ok, guards]


def _numbered(steps: Iterable[str]) -> list[str]:
    return [f"{k}. {step}." for k, step in enumerate(steps, start=1)]


def _names(coordinates: Sequence[Coordinate]) -> str:
    return ", ".join(f"`{c.name}`" for c in coordinates)


# --- which answer is OK ---------------------------------------------------------------------------


def _newton(program: Program) -> str:
    """What holds of Newton's method, as far as it does for the kernel."""
    kernel, kind = program.main.kernel, program.kind
    ground = (
        "redundant_arm" if kernel.is_wide else "banach" if kernel.reads_known else "kantorovich"
    )
    dead = ""
    if isinstance(kind, LimbPlatform) and kind.has_dead_centres:
        dead = "\n\n" + _words("side" if kind.tells_branch else "dead_centre")
    rule = _words("rule", sign=_SIGN if kernel.is_square else "", dead_centres=dead)
    return f"{_words('branch')}\n\n{_words(ground)}\n{rule}"


def _map_answers(program: Program, kind: JointMap) -> str:
    closed = [d.is_closed for d in (kind.direct, kind.inverse)]
    guards = [guard for _, own in program.watched.values() for guard in own]
    lines = [_words("map_line"), bend_words(guards)] if any(closed) else []
    begin = _words("all_closed") if all(closed) else _newton(program)
    return "\n\n".join([begin, _words("guess"), _words("held"), *lines])


# --- formulas -------------------------------------------------------------------------------------


def _limbs(kind: LimbPlatform) -> list[str]:
    """The section on limbs in closed form, where there are any: their derivations, and which limbs
    have none.
    """
    if all(block.formulas is None for block in kind.blocks):
        return []
    lines = [_words("formulas"), ""]
    for block in kind.blocks:
        if block.formulas is not None:
            lines += [f"{_names(block.system.unknowns)}:", "", *_numbered(block.formulas.steps), ""]
    iterated = [
        c for block in kind.blocks if block.kernel is not None for c in block.system.unknowns
    ]
    if iterated:
        lines += [
            f"No closed form was found for {_names(iterated)}: Newton's method finds these.",
            "",
        ]
    return ["\n".join(lines)]


def _pose_rows(kind: LimbPlatform) -> list[str]:
    """How the direct problem's rows over the pose are made, nothing where passive joints stay."""
    if kind.core is None:
        return []
    return ["\n".join([_words("rows_over_pose"), "", *_numbered(map(markdown, kind.core.steps))])]


def _direct_formulas(kind: LimbPlatform, *, implied: bool) -> list[str]:
    """A direct problem that formulas solve: derivation, and what is proved of the line."""
    found = kind.direct_formulas
    assert found is not None  # noqa: S101 - the caller has looked
    whole = found.whole.pose_choices == len(found.formulas.names)
    ground = "implied" if kind.held is None else "implied_by_volume"
    motion = [_words(ground, motion=kind.mechanism.motion, count=CONFIGURATIONS)] if implied else []
    return [
        _words("direct_by_formulas" if whole else "limb_by_limb"),
        *motion,
        "\n".join(_numbered(found.formulas.steps)),
        _words("direct_line"),
        bend_words(found.guards),
        _words("direct_side"),
    ]


def _closed_form(kind: SerialArm) -> list[str]:
    """The section on an arm's closed form."""
    if kind.plan is None:
        return [_words("not_closed")]
    plan, nearly = kind.plan
    return [
        _words("closed_form", p=kind.name),
        *([_words("nearly_closed")] if nearly else []),
        "\n".join(_numbered(map(markdown, plan.derivation()))),
    ]


# --- maps -----------------------------------------------------------------------------------------


def _of_map(made: JointMap) -> str:
    """The equations of a map, block by block."""
    directions = (made.direct, made.inverse)
    forms = [part.form for d in directions for part in d.parts if part.form is not None]
    harmonic = [_words("harmonic"), ""] if any(len(form.names) for form in forms) else []
    return "\n".join([_words("map"), "", *(_direction(made, d) for d in directions), *harmonic])


def _direction(made: JointMap, direction: Direction) -> str:
    """The blocks of one direction."""
    wanted = _names(made.found if direction.name == "direct" else made.given)
    lines = [f"### `{made.name}_{direction.name}`: {_names(direction.known)} to {wanted}", ""]
    for part in direction.parts:
        lines += [_part(part), ""]
    if not direction.is_closed and len(direction.parts) > 1:
        lines += ["Not all blocks have a closed form: Newton's method solves them together.", ""]
    return "\n".join(lines)


def _part(part: Part) -> str:
    """How a block is solved."""
    system = part.problem.system
    head = f"- {_names(system.unknowns)} of {_names(part.problem.known_coordinates)}: "
    if part.form is not None:
        return head + "; ".join(part.form.steps) + "."
    if part.total is not None or part.is_linear:
        return head + "linear (a coupling)."
    return head + (
        f"no closed form was found; Newton's method on {system.freedom} unknowns, "
        f"{system.rows.numel()} rows."
    )
