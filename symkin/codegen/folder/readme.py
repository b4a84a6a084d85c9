"""Write the README.md of a generated folder: how to use it, the equations that it solves, and what
is proved of its answers. Its words, and which of them are said, stand in templates/readme.md.
"""

from __future__ import annotations

from collections.abc import Sequence

from symkin.codegen.map.implied_platform import CONFIGURATIONS
from symkin.codegen.map.joint_map import JointMap
from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.map.program import Program
from symkin.codegen.map.rod_platform import RodPlatform
from symkin.codegen.steps.guard_text import bend_words, guard_tables
from symkin.codegen.text.latex import equations
from symkin.codegen.text.templates import rendered
from symkin.model.file import shipped
from symkin.model.joint import Coordinate
from symkin.model.mechanism import Mechanism
from symkin.model.oddities import degrees_question
from symkin.model.shipped import shipped_names


def readme(program: Program) -> str:
    """Markdown with the equations in LaTeX."""
    kind, mechanism, platform, forms = program.kind, program.mechanism, list[Coordinate](), False
    if isinstance(kind, LimbPlatform):
        blocks = [block for block in kind.blocks if block.kernel is not None]
        platform = [c for block in blocks for c in block.system.unknowns]
    if isinstance(kind, JointMap):
        parts = (part.form for d in (kind.direct, kind.inverse) for part in d.parts)
        forms = any(form is not None and len(form.names) for form in parts)
    return rendered(
        "readme.md",
        program=program,
        kind=kind,
        main=program.main,
        kernel=program.main.kernel,
        p=mechanism.name,
        known=_is_shipped(mechanism),
        question=degrees_question(mechanism),
        names=_names,
        is_rods=isinstance(kind, RodPlatform),
        iterated=platform,
        harmonic=forms,
        count=CONFIGURATIONS,
        bend_words=bend_words,
        guards=[guard for _, own in program.watched.values() for guard in own],
        guard_tables=guard_tables(mechanism.name, program.watched),
        closure=equations(mechanism),
    )


def _names(coordinates: Sequence[Coordinate]) -> str:
    return ", ".join(f"`{c.name}`" for c in coordinates)


def _is_shipped(mechanism: Mechanism) -> bool:
    """Whether a command takes the name; of a file's mechanism, which may have the same name, it
    takes the path.
    """
    if mechanism.name not in shipped_names():
        return False
    ours = shipped(mechanism.name)
    return (ours.title, ours.source) == (mechanism.title, mechanism.source)
