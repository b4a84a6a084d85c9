"""Say in the README of a generated folder how the direct problem's rows over the pose are made."""

from __future__ import annotations

from symkin.codegen.pose_core import PoseCore
from symkin.text import markdown

_TEXT = r"""## Rows over the pose

The limbs' passive joints are taken out of the rows, so that Newton's method finds the pose alone. A
limb holds a platform point $B = p + R\,a$ by rows $B + f(q, x) = 0$; combinations of them in which
no passive joint $x$ stands are

$$|B - A(q)|^2 - c(q) = 0 \quad\text{(a sphere)}, \qquad n(q) \cdot B - c(q) = 0 \quad\text{(a
plane)} .$$

With $v_0$ the velocity of the platform where the base's origin is, and $\omega$ its angular
velocity,

$$\tfrac12\,\mathrm{d}|B - A|^2 = (B - A) \cdot v_0 + (A \times B) \cdot \omega, \qquad \mathrm{d}(n
\cdot B) = n \cdot v_0 + (B \times n) \cdot \omega .$$

A passive joint turns a vector of a length $l$: its column in the closure's matrix is $l$ across
that vector, and the sphere's row is $l$ times the limb's rows along it. So the determinant of these
rows is the closure's but for the limbs' own lengths, and for U joints whose axes fall together (a
singularity of the joint, not of the platform); singularities are the same. $A$, $n$ and $c$ are
made once for each point of the joints' line:
"""


def rows_over_the_pose(core: PoseCore | None) -> list[str]:
    """The section, nothing where passive joints stay."""
    if core is None:
        return []
    steps = "\n".join(f"{i}. {markdown(step)}." for i, step in enumerate(core.steps, start=1))
    return [f"{_TEXT}\n{steps}"]
