"""Write the README.md of a generated folder: how to use it, the equations that it solves, and what
is proved of its answers.
"""

from __future__ import annotations

from symkin.codegen.direct_readme import direct_by_formulas
from symkin.codegen.guard_text import guard_tables
from symkin.codegen.joint_map import JointMap
from symkin.codegen.joint_map_readme import map_branch, map_chapter
from symkin.codegen.limb_platform import LimbPlatform
from symkin.codegen.pose_readme import rows_over_the_pose
from symkin.codegen.program import Program, is_closed
from symkin.codegen.rod_platform import RodPlatform
from symkin.codegen.serial_arm import SerialArm
from symkin.codegen.text.latex import equations
from symkin.model.file import shipped
from symkin.model.mechanism import Mechanism
from symkin.model.oddities import degrees_question
from symkin.model.shipped import shipped_names
from symkin.text import markdown

_RODS = r"""Platform point $A_i = p + R\,a_i$, base point $b_i$, rod vector $d_i = A_i - b_i$, rod
length $L_i$ (offset + joint value):

$$f_i = L_i^2 - d_i \cdot d_i = 0.$$

With $v_0$ the velocity of the platform at the base's origin and $\omega$ its angular velocity, a
point of it has the velocity $v_0 + \omega \times A_i$, and because $d_i \times d_i = 0$

$$\tfrac12 \, \mathrm{d}(d_i \cdot d_i) = d_i \cdot v_0 + (b_i \times d_i) \cdot \omega ,$$

so that the matrix $[\,d_i,\ 4\,b_i \times d_i\,]$ acts on the unknowns $(2 v_0, h)$,
$h = \omega / 2$. The step is put on by $q \leftarrow (1, h)\,q / \sqrt{1 + h \cdot h}$ and
$p \leftarrow p + v_0 + \omega \times p$: no trigonometry. The joint rates are
$\dot L_i = (d_i \cdot v + (R a_i \times d_i) \cdot \omega) / |d_i|$, $v$ the velocity of the
platform's origin."""

_RELATIVE = r"""
In the home-relative form $p$ and $R$ are displacements from home, $\delta_i = p + (R - 1) R_0 a_i$
with $R - 1$ formed without cancellation, $d_i = d_{0i} + \delta_i$, and

$$f_i = (2 L_{0i} + \Delta L_i) \, \Delta L_i - (2 d_{0i} + \delta_i) \cdot \delta_i ,$$

in which no large numbers cancel."""

_CLOSED = r"""The closure's rows $F(q, x, X) = 0$ over joint values $q$, passive joints $x$ and pose
$X$ follow; angular rows are multiplied by the mechanism's size so that all are lengths. @@ Given
$X$ the limbs are solved one by one, by formulas where they have a closed form."""
_ITERATED = """Given $q$, Newton's method finds $(x, X)$ together; where there are more rows than
unknowns each step is least squares over all rows (QR), and an answer must satisfy all of them."""
_SOLVED = """Given $q$, formulas give $(x, X)$ together, and an answer must satisfy all rows."""

_SERIAL = r"""The tool's pose is a product of exponentials of the joints' screws. The inverse
problem solves the rows below, position and twice the size times the vector part of the relative
quaternion, for the joint values."""

_REDUNDANT = r"""
A pose leaves some of the joints free. With $J$ of more columns than rows, each step is the shortest
solution of $J s = f$: $J^T = Q R$, $R^T y = f$, $s = Q y$, lengths as they are and angles times the
size. As pieces of the line shrink, the answer tends to the end of $\dot q = J^+ \dot X$; it keeps
to the joint values of no earlier visit, as closed paths of poses need not close in $q$."""

_EQUATIONS = {RodPlatform: _RODS, LimbPlatform: _CLOSED, SerialArm: _SERIAL}

_BRANCH = r"""## Which answer is OK

`OK` says that the answer is the one which is reached from the guess along a straight line of the
given values without meeting a singularity. Write $x_0$ for the guess's state, $J_0$ for the matrix
there, $\lambda \in [0, 1]$ for the place on the line, $s_0(\lambda)$ for Newton's first step
towards it, $s_0 = s_0(1)$, $\bar s_1$ for the next step with the same factors, and
$\theta = |\bar s_1| / |s_0|$."""

_KANTOROVICH = r"""**Proved.** Let $|J_0^{-1} (J(x) - J(y))| \le \omega |x - y|$. If
$h = \omega \max_\lambda |s_0(\lambda)| \le \tfrac12$ (Newton, Kantorovich), then for each $\lambda$
there is one solution $x(\lambda)$ within $(1 - \sqrt{1 - 2h}) / \omega$ of $x_0$, the matrix is
regular short of $1 / \omega$, and Newton's method from $x_0$ ends there. So $x(\lambda)$ is a
continuous path without a singularity and the answer is its end.

1. $\theta \le h / 2$, and with new factors $|s_1| / |s_0| \le h / (2 - 2h)$. So $\theta > \tfrac14$
   proves that the theorem says nothing about the whole line: to cut it is never a mistake of
   principle.
2. Where the rows are quadratics, as distances in Study's coordinates are, their second derivative
   $B$ is constant, $\omega = \max |J_0^{-1} B(u, v)|$ over unit $u, v$ exactly, and
   $\bar s_1 = -\tfrac12 J_0^{-1} B(s_0, s_0)$: $2 \theta$ *is* $h$ for the curvature in the step's
   own direction. A quarter is then Kantorovich's limit $h = \tfrac12$, and it is sharp: for
   $x^2 = c$ from $x_0$, $\theta = |c - x_0^2| / 4 x_0^2$, which is $\tfrac14$ at $c = 0$, where the
   two roots meet.
3. $\theta$ sees the curvature in the step's direction. What it leaves, $\bar s_1$, lies mostly
   where the matrix is nearly singular, and the next ratio $|\bar s_2| / |\bar s_1|$ sees that
   direction. For $x^2 = c$ it is $h + h^2 / 4$ with $\theta = h / 2$: 9/16 at $h = \tfrac12$, where
   the roots meet, and 3/8, the limit here, at $h = 0.345$. After new factors the step is
   $\tfrac{h}{2 - 2h}$ of the one before and $h_1 = \tfrac12 (\tfrac{h}{1 - h})^2$; at $h = 0.345$
   the next one is 2/25, the limit there.
4. For rods, whose rows hold squared lengths,
   $s_0(\lambda) = \lambda s_0 - \lambda (1 - \lambda) J_0^{-1} (\Delta L_i^2)$: on the way the
   steps are longer than $|s_0|$ by at most $\tfrac14 |J_0^{-1} (\Delta L_i^2)|$, a term of second
   order. For rows linear in $\lambda$ they are $\lambda s_0$.

**Measured, not proved.** $\omega$ over all directions is not computed; the state is a position and
a unit quaternion, in which rows are quadratics up to terms of third order only; the closures of
passive joints hold sines."""

_BANACH = r"""**Proved.** The matrix reads the given values too; $J_0$ is the one of the guess's
state and the guess's values, which the machine has. If $|1 - J_0^{-1} J(x, \lambda)| \le c < 1$ for
all $\lambda$ and all $x$ within $\max_\lambda |s_0(\lambda)| / (1 - c)$ of $x_0$, then (Banach, for
$x \mapsto x - J_0^{-1} F(x, \lambda)$) there is one solution $x(\lambda)$ there for each $\lambda$
and the matrix is regular. So $x(\lambda)$ is a continuous path without a singularity and the answer
is its end. The first step is taken with $J_0$; then $\theta \le c$, because
$\bar s_1 = (1 - J_0^{-1} \int_0^1 J(x_0 + t s_0, 1) \, \mathrm{d}t) \, s_0$: $\theta$ is the change
of the matrix, by the state along the step and by the given values along the whole line, in the
step's direction. What it leaves, $\bar s_1$, lies mostly where the matrix is nearly singular, and
$|\bar s_2| / |\bar s_1| \le c$ sees that direction.

$s_0(\lambda)$ is not $\lambda s_0$ where given values turn: a point that turns by $\varphi$ at a
radius $r$ leaves its chord by $r \varphi^2 / 8$, so that both ends of a part may have a
configuration and its middle none. So the middle of a part is reached as its end is. Parts turn by
at most one radian; then a parabola through both ends and the middle is off by at most
$0.008 \, r \varphi^3$ between them. The middle is left out where
$\varphi^2 \sum 1 / p_i^2 \le \tfrac14$, $p_i$ the scaled pivots, which estimates
$|J_0^{-1}|^2 \varphi^2$: there the bend is a small part of what the theorem allows.

**Measured, not proved.** $c$ over all directions and all of the line is not computed."""

_REDUNDANT_ARM = r"""**Measured, not proved.** The matrix has more columns than rows and reads the
given pose; each step is the shortest one of the matrix at the pose aimed at, and $\theta$ compares
successive shortest steps. No theorem is claimed."""

_RULE = r"""The rule is therefore: the whole line is tried (a part of it where given values turn
far) and accepted at $\theta \le \tfrac14$, when each later step is at most three eighths of the one
before, two twenty-fifths where that one had new factors; elsewhere it is cut into pieces, each
accepted after three steps by the same rule, after four where the first step is far and the third is
above a fifth of the second. A first step is far where its square times $1 / p$ ($p$: the least
pivot) is above the size's: asked is then $\theta \le \tfrac16$, and ten times as far
$\theta \le \tfrac18$, or $h = \tfrac14$, where later steps are at most 3/10 ($1 - \sqrt{1 - 2h}$),
after new factors 3/100, of the ones before; where pieces become shorter than 1/1024@@, the status
is `WRONG_BRANCH`. That no answer called OK lies on another branch rests on random goals compared
with fine continuation.@@

The predicted error of a step $s$ is $\kappa |s|^2$, $\kappa = |s_1| / |s_0|^2$; when it is below
the tolerance the rows are evaluated once more and must vanish to the tolerance plus 8 roundings of
the size; where they do not, one more step with new factors is taken, and 64 are allowed, which the
rows of an ill-conditioned answer may leave. Steps that 64 roundings of the rows can make are
rounding and not judged by the one before, unless the rounding could reach a singularity; a whole
line that is refused though 256 roundings can make its first step is none where the rows close to 64
of them at its beginning: there the state stays; else parts of it are tried."""
_SIGN = r", or the sign of $\det J$ (free with the pivots) has changed where one ends"
_DEAD_CENTRE = r"""

A limb's dead centre is a singularity too, and a pose alone does not say on which side of it the
limb stands. So the limbs are solved at the answer, along the line of poses from the reference as
`inverse` solves them: where they have other joint values than the given ones (by more than four
square roots of the tolerance over the size), or that line leaves what the limb can take, the status
is `WRONG_BRANCH`. The inverse of an answer called OK is what was given, and the next call can begin
there."""
_SIDE = r"""

A limb's dead centre is a singularity too, and a pose alone does not say on which side of it the
limb stands. Of a limb in closed form a sign tells that: it is taken at the answer and the given
joint values, and where it is not the reference's, the status is `WRONG_BRANCH`. An error $t$ of the
pose, over the size, is $\sqrt{t}$ there: within $4 \sqrt{t}$ of the root's usual size, $t$ the
tolerance's, only a change of joint values as small is OK, standing still; within eight times that
the pose, as it is written, must give the joint values back as `inverse` solves them. The inverse of
an answer called OK is what was given, and the next call can begin there."""

_FORMULAS = r"""## Limbs in closed form

Given the pose, the rows of these limbs are solved by formulas; of two values the one on the
reference's side is taken, and `OUT_OF_RANGE` says that a root's argument is negative. $x$ are
lengths, $t$ angles, capitals what is known:

$$x^2 + 2 h x + e = 0: \quad x = -h \pm \sqrt{h^2 - e}$$

$$A \cos t + B \sin t + C = 0: \quad (\cos t, \sin t) = \frac{(-A C \mp B r,\ -B C \pm A r)}{A^2 +
B^2}, \quad r = \sqrt{A^2 + B^2 - C^2}$$

Two rows that are linear in $\cos t$ and $\sin t$ give both by Cramer's rule. Joint rates are the
derivatives of the formulas, with $\mathrm{d} \sqrt{D} = \mathrm{d} D / (2 \sqrt{D})$; `jacobian` is
`SINGULAR` where a root is a thousandth of its usual size."""


def _formulas(program: Program) -> list[str]:
    """The section on limbs in closed form, where there are any: their derivations, and which limbs
    have none.
    """
    kind = program.kind
    if not isinstance(kind, LimbPlatform) or all(block.formulas is None for block in kind.blocks):
        return []
    lines = [_FORMULAS, ""]
    for block in kind.blocks:
        if block.formulas is not None:
            names = ", ".join(f"`{c.name}`" for c in block.system.unknowns)
            lines += [
                f"{names}:",
                "",
                *(f"{k}. {step}." for k, step in enumerate(block.formulas.steps, start=1)),
                "",
            ]
    iterated = [
        c.name for block in kind.blocks if block.kernel is not None for c in block.system.unknowns
    ]
    if iterated:
        lines += [
            f"No closed form was found for {', '.join(f'`{name}`' for name in iterated)}: "
            f"Newton's method finds these.",
            "",
        ]
    return ["\n".join(lines)]


def _over_the_pose(program: Program) -> list[str]:
    return rows_over_the_pose(program.kind.core) if isinstance(program.kind, LimbPlatform) else []


_LIBM = """ (with the same libm: its sin and cos differ from one library to another in the last bit,
and results with them)"""


def _branch(program: Program) -> str:
    """The section on which answer is OK, as far as it holds for the kernel."""
    kernel, kind = program.main.kernel, program.kind
    if isinstance(kind, LimbPlatform) and kind.direct_formulas is not None:
        return "\n\n".join(
            direct_by_formulas(
                kind,
                kind.direct_formulas,
                implied=kind.mechanism.motion != program.lowered.motion,
            )
        )
    if isinstance(kind, SerialArm) and kind.follows_closed_form:
        return _CLOSED_LINE
    pieces = _RULE.split("@@")
    rule = (
        pieces[0]
        + (_SIGN if kernel.is_square else "")
        + pieces[1]
        + _dead_centres(program)
        + pieces[2]
    )
    ground = _REDUNDANT_ARM if kernel.is_wide else _BANACH if kernel.reads_known else _KANTOROVICH
    found = "\n\n".join([_BRANCH, f"{ground}\n{rule}"])
    guards = [guard for _, own in program.watched.values() for guard in own]
    return map_branch(kind, found, guards) if isinstance(kind, JointMap) else found


_CLOSED_FORM = r"""## Closed form

Write $F_i$ for the motion of joint $i$ from the reference and $M = F_1 \cdots F_n$ for that of the
tool. Each step below decides one joint: it carries a known point or direction to another, $F x = y$
(one solution, by atan2), or brings it to a level or to a distance, $A \cos q + B \sin q = C$ with
the two solutions

$$\cos q = \frac{A C \mp B \sqrt{A^2 + B^2 - C^2}}{A^2 + B^2}, \qquad \sin q = \frac{B C \pm A
\sqrt{A^2 + B^2 - C^2}}{A^2 + B^2} .$$

A slide's level is linear and its distance a quadratic. `NAME_inverse_all` runs through both
solutions of each choice, in loops within each other, `NAME_inverse_branch` takes the ones that its
bits name (the first where a bit is 0), and `NAME_inverse_nearest` those next to the guess $g$: the
upper sign where $A \sin g - B \cos g \ge 0$. A negative root is a pose out of reach
(`OUT_OF_RANGE`); where $A$ and $B$, or both vectors of $F x = y$ across the axis, vanish, nothing
decides the joint (`SINGULAR`). `NAME_inverse` follows the line from the guess; it is the one that
says whether the arm can move there. Angles of the closed form are atan2 of libm in double and a
polynomial in float (error $4 \cdot 10^{-8}$ and rounding, the same bits on every machine)."""
_CLOSED_LINE = r"""## Which answer is OK

`OK` says that the answer is the one which the arm reaches from the guess when its tool moves in a
straight line (place) and along the shorter arc (turn). It is the closed form's branch on which the
guess lies (below), and on the way each step must decide its joint. Write $D$ for what a step must
keep above zero: $(A^2 + B^2 - C^2)$, or the square of the length that a point or direction has
across the axis, over the size. As a function of the tool's pose and of the joints before it, $D$ is
a polynomial in them, their sines and cosines, and its second derivatives are bounded by weights
$w$, taken over 400 random configurations and raised by a quarter. Between two points $a$, $b$ of
the line,

$$D \ge 0 \quad \text{where} \quad 2 \sum_i w_i\, \Delta_i^2 < 2 (D_a + D_b) + 4 \min(D_a, D_b),$$

$\Delta$ the changes of place, turn and joints between them; the factor 2 on the left is for speeds
that change on the way. **Sampled and measured, not proved:** the whole line is tried, and cut where
this does not hold, at most down to 1/4096, and within the iterations that the config allows. Angles
go on from part to part by less than 1.5 rad, so that whole turns are told. A point without the
branch is `WRONG_BRANCH`, the goal without it `OUT_OF_RANGE`, and `SINGULAR` where $D$ is within 256
roundings of 0. `codegen/bench/arm_lines.c` follows lines that are OK in thousands of points. Where
joints have limits, a joint is at its limit $l$ where the equation of its step holds for $l$: the
value of that equation there is a function like $D$, and must keep its sign by the same bound; where
the step's other solution is at $l$, its branch tells. A line on which a joint leaves its limits is
`OUT_OF_RANGE`. `info->iterations` counts points of the line, `info->min_pivot` is the least
$\sqrt{D}$ at the answer. The tool's pose of every answer is held against the given one:
`info->residual` is their difference. Beside a fold, where the formulas lose digits, one step of
Newton's method gives them back; what then is further off than four tolerances and 64 roundings of
the size is `SINGULAR`. `NAME_inverse_nearest`, `NAME_inverse_branch` and `NAME_inverse_all` hold
their answers against the pose in the same way."""
_NEARLY_CLOSED = """The axes of this arm are only nearly as the steps ask. They give the joints of
the ideal arm, and a few steps of Newton's method, which must end within the tolerance, those of
this one: near a double root of the steps solutions may be missing."""
_NOT_CLOSED = """## Closed form

None was found: the axes of this arm are neither parallel nor meeting in a way that decides its
joints one after the other by formulas (three consecutive parallel axes beside others that meet or
are parallel; a spherical wrist at either end with a pair that is parallel or meets; slides in their
places), or its geometry is given at run time. The inverse problem is solved by iteration."""


def _closed_form(program: Program) -> list[str]:
    """The section on an arm's closed form, nothing for other machines."""
    kind = program.kind
    if not isinstance(kind, SerialArm):
        return []
    if kind.plan is None:
        return [_NOT_CLOSED]
    plan, nearly = kind.plan
    steps = "\n".join(
        f"{i}. {markdown(line)}." for i, line in enumerate(plan.derivation(), start=1)
    )
    return [_CLOSED_FORM.replace("NAME", kind.name), *([_NEARLY_CLOSED] if nearly else []), steps]


def _dead_centres(program: Program) -> str:
    """What is said of limbs' dead centres."""
    kind = program.kind
    if not kind.has_dead_centres or not isinstance(kind, LimbPlatform):
        return ""
    return _SIDE if kind.tells_branch else _DEAD_CENTRE


def _is_shipped(mechanism: Mechanism) -> bool:
    """Whether a command takes the name; of a file's mechanism, which may have the same name, it
    takes the path.
    """
    if mechanism.name not in shipped_names():
        return False
    ours = shipped(mechanism.name)
    return (ours.title, ours.source) == (mechanism.title, mechanism.source)


def _described(mechanism: Mechanism) -> str:
    """The mechanism as a command names it."""
    return mechanism.name if _is_shipped(mechanism) else "MECH"


def _of_file(mechanism: Mechanism) -> str:
    return (
        ""
        if _is_shipped(mechanism)
        else " (`MECH`: the file that describes the machine, with the options by which it was read)"
    )


def readme(program: Program) -> str:
    """Markdown with the equations in LaTeX."""
    mechanism, options = program.mechanism, program.options
    name = mechanism.name
    solved = _SOLVED if is_closed(program.kind) else _ITERATED
    text = (
        map_chapter(program.kind)
        if isinstance(program.kind, JointMap)
        else _EQUATIONS[type(program.kind)].replace("@@", solved)
    )
    kind = text + (_RELATIVE if options.home_relative else "")
    kind += "\n" + _REDUNDANT if program.kind.is_redundant else ""
    closure = equations(mechanism)
    chapters = "\n\n".join(
        [
            kind,
            *_over_the_pose(program),
            *_formulas(program),
            _branch(program),
            guard_tables(name, program.watched),
            *_closed_form(program),
        ]
    )
    counts = "; ".join(f"{what}: {count}" for what, count in program.main.operations.items())
    step = (
        "One evaluation of formulas for each part of the line"
        if is_closed(program.kind)
        else f"One step: {counts}"
    )
    question = degrees_question(mechanism)
    asked = "" if question is None else f"\n\n**Note**: {markdown(question)}"
    return f"""# {name}: {markdown(mechanism.title) or "generated kinematics"}

C99 for controllers, generated by
`symkin firmware {_described(mechanism)} {options.arguments} -o DIR`{_of_file(mechanism)}.
`{name}.c` and `{name}.h` are all that a project needs; they use
`{"sin and cos, " if program.main.operations.get("sin") else ""}sqrt` and `fabs` of libm, no heap,
no globals. Lengths in {mechanism.length_unit}, angles in radians.{asked}

    make test          # builds and runs {name}_test against vectors from Python
    cmake -B build && cmake --build build && ctest --test-dir build

Compile with `-fno-math-errno` (square roots become one instruction) and `-ffp-contract=off` where
the same bits are wanted on every machine{_LIBM if program.main.operations.get("sin") else ""}.
Source: {markdown(mechanism.source) or "not given"}.

{step}. Tolerance {program.main.tuning.tolerance:.2g} {mechanism.length_unit}.

{program.worst.chapter()}

## Equations

{chapters}

## Closure

```latex
{closure}
```

Model SHA-256: `{program.described.digest}`
"""
