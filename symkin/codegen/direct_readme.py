"""Write the chapters of a README on a direct problem that formulas solve: derivation, and what is
proved of lines.
"""

from __future__ import annotations

from symkin.codegen.direct_formulas import DirectFormulas, Guard
from symkin.codegen.implied_platform import CONFIGURATIONS
from symkin.codegen.limb_platform import LimbPlatform

_DIRECT_BY_FORMULAS = r"""## Direct problem in closed form

Given $q$, all rows together are solved for pose and passive joints by the formulas below; of two
values the one on the guess's side is taken."""

_LIMB_BY_LIMB = r"""## Direct problem in closed form

Given $q$, the pose is solved first, from combinations of the limbs' rows that no passive joint
enters, then each limb's passive joints by its pose and actuated joint, by the formulas below; of
two values the one on the guess's side is taken. A passive joint has two values where
$N = A^2 + B^2$ is above $C^2$. Where $C = a + b N$ (the law of cosines), a limb reaches the pose
while $N_{low} < N < N_{high}$; these differences, which bend less than $N - C^2$ does, are then
among the $g$ below. ($N$ itself is a sum of squares, which no line in general makes zero.)"""

_IMPLIED = r"""The model declares no motion. Its joints leave the platform a @@ one, and the code is
that of a platform of this motion. The wrenches by which the limbs hold it there could lose their
rank along a line, and the platform leave the motion, only where the determinants of all sets of
them vanish. A sum of multiples of these determinants' squares is constant, or is a divisor $v$
below or its square (compared at @n@ configurations): where no $v$ is zero, the platform keeps to
the motion."""
_IMPLIED_BY_VOLUME = r"""The model declares no motion. Its joints leave the platform a @@ one, and
the code is that of a platform of this motion. Each limb holds it by one wrench, whose direction is
linear in the platform's position (compared at @n@ configurations). Where the determinant of these
wrenches is zero, the platform could leave the motion, and where a limb's wrench is, its passive
joints are not decided. The determinant is one of the $g$ below (without the root of a $D$ that it
is a multiple of), so that neither happens on the line."""

_LINE = r"""## Which answer is OK

`OK` says that the answer is the one which is reached from the guess along a straight line of the
given values without meeting a singularity: every point of that line has a real configuration and is
regular.

The guess's joint values come from its pose by the limbs' formulas, and its side of each choice is
the sign of what tells it (sign times root). With these signs the formulas give one configuration
for each point of the line, which changes continuously as long as no discriminant $D$ reaches zero,
where two configurations meet, and no divisor $v$. Each of these, discriminants times powers of
divisors so that nothing is divided, is a polynomial $g$ in the given lengths and in cosines and
sines of the given angles: a finite sum of waves in the angles and of Chebyshev polynomials in the
lengths over their ranges, with amplitudes $a$. On a part of the line, $t$ from 0 to 1, given values
change by $d_i$, and at all its points

$$|g''(t)| \le \sum_a |a| \Big(\sum_i k_i |d_i|\Big)^2 \le \sum_i W_i \, d_i^2 =: 2 K,$$

$k_i$ the order of the wave (of a Chebyshev polynomial its largest derivatives). So
$g(t) \ge (1 - t) g_0 + t g_1 - K t (1 - t)$, which is above zero for all $t$ where
$K < (\sqrt{g_0} + \sqrt{g_1})^2$. **Proved**: the part is accepted where
$K < g_0 + g_1 + 2 \min(g_0, g_1)$, which is not more; the whole line is tried first, what is
refused is cut to nine tenths of what $K$ lets pass. A point at which some $g$ is not above its
rounding is a point without a configuration or a singular one, and parts shorter than 1/4096 pass
too near to one: the status is then `WRONG_BRANCH`. (Of an angle up to a right one with the chord
$c$ the square is at most $c^2 + 0.117 c^4$: no angle is formed before a line has to be cut.) Slides
without limits are looked at within two sizes of the machine about the reference; beyond them
nothing is assured. Lines within a sixteenth or a quarter of the slides' ranges have bounds of their
own, which are smaller.

A discriminant that holds the root $r$ of another one, $D$, is $P + Q r$ with polynomials $P$ and
$Q$; where $D \ge m$ on a part of the line, $r' = D' / (2 r)$ and
$r'' = D'' / (2 r) - D'^2 / (4 r^3)$ give

$$|(P + Q r)''| \le |P''| + |Q''| \, r + |Q'| \, |D'| \, m^{-1/2} + |Q| \, (\tfrac12 |D''| \,
m^{-1/2} + \tfrac14 D'^2 \, m^{-3/2}),$$

each by its amplitudes; $m$ is the bound of $D$ from below by its own $K$, $\min(g_0, g_1) - K / 4$.

The amplitudes are those of exact trigonometric interpolation of $g$, compared with it at points of
their own when the code was generated. Values of $g$ below 64 roundings of the sum of its amplitudes
count as zero, which is that over the part of the slides' ranges where the line lies."""

_LINE_SIDE = r"""A limb's dead centre leaves the direct problem regular, but a pose does not say on
which side of it the limb stands: its sign is taken at the answer, and where it is not the
reference's, the status is `WRONG_BRANCH`. Near a dead centre or a fold the pose, rounded, may lie
beyond it: an answer with a root below 1/64 of its usual size, a side within 32 square roots of the
tolerance over the size, or a $g$ below 64 times its rounding is read once more as a guess, and is
`WRONG_BRANCH` where it would not stand still. The inverse of an answer called OK is what was given,
and the next call can begin there. Last, the rows of the closure must vanish at the answer, to the
tolerance and rounding; else the formulas have lost their digits (`SINGULAR`)."""


def _guard_row(guard: Guard) -> str:
    """A guard's line in the table: its bound of K over the widest ranges, and that of itself."""
    last = guard.weights[-1]
    parts = [(last.plain, ""), (last.by_root, r" m^{-1/2}"), (last.by_cube, r" m^{-3/2}")]
    sums = [
        " + ".join(f"{v[i]:.3g}{factor}" for v, factor in parts if v[i] > 0) or "0"
        for i in range(len(last.plain))
    ]
    return f"| {guard.name} | {', '.join(f'${text}$' for text in sums)} | {guard.sizes[-1]:.3g} |"


def direct_by_formulas(kind: LimbPlatform, found: DirectFormulas, *, implied: bool) -> list[str]:
    """The sections on a direct problem that formulas solve: derivation, and what is proved of the
    line.
    """
    steps = "\n".join(f"{k}. {step}." for k, step in enumerate(found.formulas.steps, start=1))
    joints = ", ".join(f"`{c.name}`" for c in kind.actuated)
    rows = [_guard_row(guard) for guard in found.guards]
    table = "\n".join(
        [f"| $g$ of | $W / 2$ for {joints} | sum of amplitudes |", "|---|---|---|", *rows]
    )
    begin = (
        _DIRECT_BY_FORMULAS
        if found.whole.pose_choices == len(found.formulas.names)
        else _LIMB_BY_LIMB
    )
    text = _IMPLIED if kind.held is None else _IMPLIED_BY_VOLUME
    motion = (
        [text.replace("@@", kind.mechanism.motion).replace("@n@", str(CONFIGURATIONS))]
        if implied
        else []
    )
    return [begin, *motion, steps, _LINE, table, _LINE_SIDE]
