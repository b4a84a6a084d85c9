"""Write the chapters of a README on a direct problem that formulas solve: derivation, and what is
proved of lines.
"""

from __future__ import annotations

from symkin.codegen.direct_formulas import DirectFormulas
from symkin.codegen.guard_text import bend_words
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
for each point of the line. Guards are discriminants times powers of divisors, so that nothing is
divided. The whole line is tried first, and what is refused is cut to nine tenths of what $K$ lets
pass. (Of an angle up to a right one with the chord $c$ the square is at most $c^2 + 0.117 c^4$: no
angle is formed before a line has to be cut.) Slides without limits are looked at within two sizes
of the machine about the reference; beyond them nothing is assured."""

_LINE_SIDE = r"""A limb's dead centre leaves the direct problem regular, but a pose does not say on
which side of it the limb stands: its sign is taken at the answer, and where it is not the
reference's, the status is `WRONG_BRANCH`. Near a dead centre or a fold the pose, rounded, may lie
beyond it: an answer with a root below 1/64 of its usual size, a side within 32 square roots of the
tolerance over the size, or a $g$ below 64 times its rounding is read once more as a guess, and is
`WRONG_BRANCH` where it would not stand still. The inverse of an answer called OK is what was given,
and the next call can begin there. Last, the rows of the closure must vanish at the answer, to the
tolerance and rounding; else the formulas have lost their digits (`SINGULAR`)."""


def direct_by_formulas(kind: LimbPlatform, found: DirectFormulas, *, implied: bool) -> list[str]:
    """The sections on a direct problem that formulas solve: derivation, and what is proved of the
    line.
    """
    steps = "\n".join(f"{k}. {step}." for k, step in enumerate(found.formulas.steps, start=1))
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
    return [begin, *motion, steps, _LINE, bend_words(found.guards), _LINE_SIDE]
