"""Write how far the parts of a line reach that Newton's method takes at once: the first, the next,
a nearer one, and their middles.
"""

from __future__ import annotations

from dataclasses import dataclass

from symkin.codegen.steps.newton_kernel import Kernel
from symkin.codegen.steps.pose_kernel import PoseKernel
from symkin.codegen.text.c import Emitter, Real, block, indexed

FIRST_TURN = 0.5
"""Turn of the known values that is tried first (rad): most longer ones are refused."""
LONGEST_TURN = 1.0
"""Largest turn of a known value in a part of the line (rad): within it the middle stands for all
points between the ends.
"""
_STRAIGHT2 = 0.25
"""Square of the turn times `spread`, an estimate of |J^-1|^2, below which the rows' change is as
good as straight: its bend is an eighth of the turn's square, which is then a small part of what
Newton and Kantorovich allow.
"""


@dataclass(frozen=True, eq=False)
class LineParts:
    """Values of the driver's template for one kernel, whose functions begin with `k`;
    `still2`: C text of the square of a step that is rounding; `bends`, `first_turn`,
    `measured` and `keeps_known` as of `NewtonCode`.
    """

    kernel: Kernel
    real: Real
    k: str
    still2: str
    bends: bool
    first_turn: float
    measured: bool
    keeps_known: bool

    @property
    def values(self) -> dict[str, object]:
        return self._turning | self._stretching

    @property
    def _turning(self) -> dict[str, object]:
        """What known values that turn ask for: a first part, a longest part, and the middle of each
        part.
        """
        floor = f"(size <= {self.still2})"
        doubled = "stretch * part" if self.measured else "quick ? (part + part) : part"
        if not self.bends:
            return {
                "turn": "",
                "check_middle": "",
                "still": floor,
                "next_part": f"({doubled})",
                "first_try": "The whole line is tried first",
            }
        first, middle = self.first_turn, "done + 0.5 * (aim - done)"
        check = [
            f"if (accepted && (taken == 1U) && ((aim - done) * (aim - done) * turn2 * w->spread > "
            f"{_STRAIGHT2})) {{",
            f"    accepted = {self.k}_reaches_middle(GEOMETRY w, to, {middle}, still2);",
            *([] if self.keeps_known else [f"    {self.k}_set_target(GEOMETRY w, to, aim);"]),
            "}",
        ]
        start = [
            "/* the square of the largest turn of a known value on the line (rad), and what part "
            "of the line is tried first */",
            *self._turn_lines,
            f"if (turn2 > {first**2}) {{",
            f"    aim = {first} / sqrt(turn2);",
            "}",
        ]
        longest = (0.5 * LONGEST_TURN) ** 2
        return {
            "turn": start,
            "check_middle": check,
            "still": f"((taken > 0U) && {floor})",
            "next_part": self._longer(f"part * part * turn2 <= {longest}"),
            "first_try": "A part in which known values turn by at most "
            f"{first:g} rad is tried first",
        }

    def _longer(self, fits: str) -> str:
        """The next part, where parts are bounded: `fits` says of half of it that the whole does."""
        if not self.measured:
            return f"(quick && ({fits})) ? (2.0 * part) : part"
        return f"((stretch < 1.0) || ({fits})) ? (stretch * part) : part"

    @property
    def _stretching(self) -> dict[str, object]:
        """How far the next part reaches: half or twice, or, where `measured`, as far as the ratio
        of steps, which grows with the part, lets expect.
        """
        nearer = "aim = done + 0.375 * (aim - done);"
        if not self.measured:
            return {
                "quick_variable": (
                    "bool quick = false; /* whether the second step was far shorter than it "
                    "had to be */"
                ),
                "set_quick": "quick = (size * 100.0 <= before);",
                "set_stretch": "",
                "nearer": [nearer],
            }
        return {
            "quick_variable": (
                "real stretch = 1.0; /* how much longer the next part may be than the last */"
            ),
            "set_quick": "stretch = 2.0;",
            "set_stretch": block(
                "if ((size * stretch * stretch > 0.64 * limit) && ((taken == 1U) || "
                f"(size > {self.still2})))",
                ["stretch = 0.8 * sqrt(limit / size);"],
            ),
            "nearer": (
                [
                    "if ((size > limit) && (size < 4.0 * limit)) {",
                    "    aim = done + 0.8 * sqrt(limit / size) * (aim - done);",
                    "} else {",
                    "    " + nearer,
                    "}",
                ]
            ),
        }

    @property
    def _turn_lines(self) -> list[str]:
        """Statements that set turn2: angles and rods' lengths over the size by their largest, a
        quaternion by its own turn.
        """
        turns = self.kernel.turns
        lines, start = ["real turn2 = 0.0;"], self.kernel.quaternion
        if turns:
            places, parts = (
                ", ".join(text)
                for text in zip(*((str(i), str(weight)) for i, weight in turns), strict=True)
            )
            lines += [
                f"static const uint8_t places[{len(turns)}] = {{ {places} }};",
                f"static const real radians[{len(turns)}] = {{ {parts} }};",
                f"for (int i = 0; i < {len(turns)}; ++i) {{",
                "    const real turned = radians[i] * (to[places[i]] - w->at[places[i]]);",
                "    if (turned * turned > turn2) {",
                "        turn2 = turned * turned;",
                "    }",
                "}",
            ]
        if start is not None:
            cosine = " + ".join(f"(w->at[{i}] * to[{i}])" for i in range(start, start + 4))
            lines += [
                f"const real cosine = {cosine}; /* of half the turn */",
                "turn2 = 8.0 * (1.0 - fabs(cosine));",
            ]
        return lines


def line_target(count: int, quaternion: int | None) -> list[str]:
    """Statements that set w->k on the line from w->at to `to`; unit quaternions go along the
    shorter arc, with the sign of the guess's.
    """
    loop = f"for (int i = 0; i < {count}; ++i) {{"
    lines = [loop, "    w->k[i] = to[i];", "}"]
    at, to, k = (indexed(name, 4, quaternion or 0) for name in ("w->at", "to", "w->k"))
    if quaternion is not None:
        lines.append("/* of q and -q, one rotation, the one on the guess's side */")
        lines.append(
            f"if ({' + '.join(f'{a} * {b}' for a, b in zip(at, to, strict=True))} < 0.0) {{"
        )
        lines += [*(f"    {v} = -{v};" for v in k), "}"]
    lines += [
        "if (part < 1.0) {",
        f"    {loop}",
        "        w->k[i] = w->at[i] + part * (w->k[i] - w->at[i]);",
        "    }",
    ]
    if quaternion is not None:
        square = " + ".join(f"({v} * {v})" for v in k)
        lines.append(f"    const real inverse = 1.0 / sqrt({square});")
        lines += [f"    {v} *= inverse;" for v in k]
    return [*lines, "}"]


def core_target(made: PoseKernel, real: Real) -> list[str]:
    """Statements that set w->k, known values of joint values, at a part of the joints' line from
    w->at to `to`: sin and cos of each joint once.
    """
    count = made.joints.numel()
    return [
        f"real q[{count}];",
        f"for (int i = 0; i < {count}; ++i) {{",
        "    q[i] = (part < 1.0) ? (w->at[i] + part * (to[i] - w->at[i])) : to[i];",
        "}",
        *Emitter.of(real, [(made.joints, "q")], made.target).stored("w->k"),
    ]
