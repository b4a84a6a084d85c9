"""Write what the README of a map between joints says: the blocks, their formulas, and which answer
is OK.
"""

from __future__ import annotations

from collections.abc import Sequence

from symkin.codegen.composed import Part
from symkin.codegen.guard_text import bend_words
from symkin.codegen.guards import Guard
from symkin.codegen.joint_map import Direction, JointMap

_MAP = r"""The loops hold the given coordinates $q$, the found ones $X$ and passive ones $x$; their
rows are $F(q, X, x) = 0$ (below; angular rows are multiplied by the machine's size). Either
direction solves them for all that it is not given, in blocks one after another (structure groups).
Angles are known by cosine and sine: a step $h$ of Newton's method turns $(c, s)$ to
$(c - s h,\ s + c h) / \sqrt{1 + h^2}$, so that no trigonometry is left in its loop.

Rates: $F_X \dot X + F_x \dot x = -F_q \dot q$, so that $\dot X = J \dot q$ with $J$ the rows of $X$
in $-[F_X\ F_x]^{-1} F_q$. Torques: the power of both sides is the same,
$\tau_q \cdot \dot q = \tau_X \cdot \dot X$ for all $\dot q$, so that $\tau_q = J^T \tau_X$.

Second derivatives: with $D_j$ the derivative along $q_j$ and the unknowns' motion with it, the rows
once more differentiated give $[F_X\ F_x]\, (X, x)_{jk} = -D_k D_j F$: the same matrix, solved for
other sides. The inverse Jacobian $G$ comes in the same way from the inverse direction. Motors of
inertias $I$ are $G^T I G$ at the found coordinates, since $\dot q^T I \dot q = \dot X^T G^T I G
\dot X$. A found torque alone asks $J_{ij} \tau_i$ of joint $j$: its limit is $\min_j L_j /
|J_{ij}|$, that of a rate $\min_j L_j / |G_{ji}|$."""

_HARMONIC = r"""Where an angle stands alone in $A \cos t + B \sin t + C = 0$, $N = A^2 + B^2$ and
$r = \sqrt{N - C^2}$ give $(\cos t, \sin t) = (-A C \mp B r,\ -B C \pm A r) / N$; a configuration is
on the upper branch where $A \sin t - B \cos t \ge 0$, which is $\pm r$. The derivative of the row
by $t$ is $\mp r$: the branches meet where it is singular."""

_LINE = r"""**Formulas.** Of each choice the sign at the guess is kept, and guards are over their
usual sizes. The whole line is tried first, and what is refused is halved."""

_GUESS = r"""**The guess** holds only one side's values. The other side's, and passive ones, are
those of the reference configuration's branch of the formulas, or, where a direction has none, those
that the machine reaches from the reference configuration in a straight line. Near the reference,
where that is printed in the code, one step of Newton's method from polynomials gives these: rays
through the reference were followed when the code was written, no determinant on them was below a
tenth of the reference's, and the step ends within $10^{-4}$ (rad, sizes) of where they lead.
Sampled, not proved."""

_HELD = r"""**An answer can be held.** The other side's values of a guess may be other ones than
those the machine had, and beside a fold an error $t$ of the given values is one of $\sqrt t$ of the
answer. So each answer is read as a guess before it is called `OK`: its configuration must have the
given values, to 256 tolerances in the rows, or lead to them and end at itself, to 16. A guess that
has the given values so, and whose line is refused or leads elsewhere, is the answer. Where the
guess's line is refused otherwise, and the given values lead from the reference configuration to the
guess, the answer is where they lead: standing still."""


def map_chapter(made: JointMap) -> str:
    """The equations of a map, block by block."""
    forms = [part.form for d in (made.direct, made.inverse) for part in d.parts]
    harmonic = any(form is not None and len(form.names) for form in forms)
    lines = [
        _MAP,
        "",
        *(_direction(made, d) for d in (made.direct, made.inverse)),
        *([_HARMONIC, ""] if harmonic else []),
    ]
    return "\n".join(lines)


def _direction(made: JointMap, direction: Direction) -> str:
    """The blocks of one direction."""
    known = ", ".join(f"`{c.name}`" for c in direction.known)
    wanted = ", ".join(
        f"`{c.name}`" for c in (made.found if direction.name == "direct" else made.given)
    )
    lines = [f"### `{made.name}_{direction.name}`: {known} to {wanted}", ""]
    for part in direction.parts:
        lines += [_part(part), ""]
    if not direction.is_closed and len(direction.parts) > 1:
        lines += ["Not all blocks have a closed form: Newton's method solves them together.", ""]
    return "\n".join(lines)


def _part(part: Part) -> str:
    """How a block is solved."""
    names = ", ".join(f"`{c.name}`" for c in part.problem.system.unknowns)
    of = ", ".join(f"`{c.name}`" for c in part.problem.known_coordinates)
    head = f"- {names} of {of}: "
    if part.form is not None:
        return head + "; ".join(part.form.steps) + "."
    if part.total is not None or part.is_linear:
        return head + "linear (a coupling)."
    count = part.problem.system.freedom
    return head + (
        f"no closed form was found; Newton's method on {count} unknowns, "
        f"{int(part.problem.system.rows.shape[0])} rows."
    )


def map_branch(made: JointMap, newton: str, guards: Sequence[Guard]) -> str:
    """Which answer is OK; `newton` is what is said of Newton's method, `guards` are those of
    formulas.
    """
    closed = [d.is_closed for d in (made.direct, made.inverse)]
    parts = [_GUESS, _HELD, *([_LINE, bend_words(guards)] if any(closed) else [])]
    if all(closed):
        head = (
            "## Which answer is OK\n\n"
            "`OK` says that the answer is the one which is reached from the guess along a straight "
            "line of the "
            "given values without meeting\na singularity."
        )
        return "\n\n".join([head, *parts])
    return "\n\n".join([newton, *parts])
