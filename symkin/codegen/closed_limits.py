"""Write the C that asks whether an arm's joints keep their limits between two points of a line.

A joint reaches its limit l where the equation of its step, E(q) = 0, holds for q = l. E(l) is a
function of the tool's pose and the joints before, like the squares of `ClosedLine`, so that bounds
of its second derivative tell whether it has a zero between two points. It is zero where the step's
other solution is at l, too: the function M(l), which has the sign of the branch there, tells these
apart (of A cos q + B sin q = C: E = A cos l + B sin l - C, M = A sin l - B cos l). A part is kept
where E has no zero, or M has the other sign throughout.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from symkin.closed.evaluation import Evaluation
from symkin.codegen.closed_line import ClosedLine, LimitCheck
from symkin.codegen.guards import Bound
from symkin.codegen.joint_ranges import range_of
from symkin.codegen.newton_kernel import rounded_up
from symkin.codegen.text.c import indent
from symkin.codegen.text.templates import fill
from symkin.computed_once import cached_property
from symkin.text import c_comment

_WITHOUT = dict.fromkeys(("guess_beyond", "blame", "and_within"), "")


@dataclass(frozen=True)
class _End:
    """A limit: the joint, whether it is the upper one, and its value."""

    joint: int
    is_upper: bool
    value: float


def limit_check(line: ClosedLine) -> LimitCheck:
    """The check of an arm's limits along the line; of an arm without limits the plain text."""
    real, p = line.real, line.code.values
    prefix, capital, count = p["p"], p["P"], f"{len(line.plan.arm)}U"
    limits = _Limits(line)
    if not limits.ends:
        plain = {"limits_kept": "    return follows;", "refused": f"{capital}_WRONG_BRANCH"}
        return LimitCheck(_WITHOUT | plain, "")
    beyond = f"    status = {capital}_OUT_OF_RANGE;"
    names = {
        "and_within": ", and the joints keep their limits",
        "guess_beyond": indent(
            [
                "w->beyond = false;",
                f"w->blamed = {prefix}_first_beyond(joints);",
                f"if (w->blamed < {count}) {{",
                beyond,
                "}",
            ]
        ),
        "limits_kept": indent(
            [
                "if (follows) {",
                f"    w->blamed = {prefix}_first_leaving(w->joints, w->found[0], change, w->way2);",
                f"    w->beyond = (w->blamed < {count}) && ({prefix}_first_beyond(w->found[0]) < "
                f"{count});",
                "}",
                f"return follows && (w->blamed == {count});",
            ]
        ),
        "refused": f"(w->blamed < {count}) ? {capital}_OUT_OF_RANGE : {capital}_WRONG_BRANCH",
        "blame": indent(
            [
                f"if ((info != NULL) && (status == {capital}_OUT_OF_RANGE)) {{",
                "    info->joint = w->blamed;",
                "}",
            ]
        ),
    }
    own = {
        "last": len(line.plan.arm) - 1,
        "limited": ", ".join(
            "true" if c.limits is not None else "false" for c in line.code.coordinates
        ),
        "values": 2 * len(limits.ends),
        "read": indent(limits.read_lines),
        "lows": ", ".join(real.literal(low) for low, _ in limits.ranges),
        "highs": ", ".join(real.literal(high) for _, high in limits.ranges),
        "per_lengths": line.per_lengths,
        "nn": len(line.plan.arm),
        "turns": 2 * len(line.plan.arm),
        "nto": len(line.ways),
        "tests": indent(limits.test_lines, 2),
    }
    members = (
        "uint8_t blamed; /* the joint that leaves its limits */",
        "bool beyond; /* whether it is beyond them where the line is tried */",
    )
    text = fill("closed_limits.c", {**p, **own})
    return LimitCheck(names, text, members, ("if (w->beyond) {", beyond, "}"))


@dataclass(frozen=True, eq=False)
class _Limits:
    """The functions E and M of all limits of an arm's joints."""

    line: ClosedLine

    @property
    def ranges(self) -> list[tuple[float, float]]:
        return [
            range_of(c, self.line.real, self.line.plan.arm.size) for c in self.line.code.coordinates
        ]

    @cached_property
    def ends(self) -> list[_End]:
        found = []
        for i, (c, span) in enumerate(zip(self.line.code.coordinates, self.ranges, strict=True)):
            if c.limits is not None:
                found += [_End(i, False, span[0]), _End(i, True, span[1])]
        return found

    def _functions(self, at: Evaluation) -> list[ca.SX]:
        """E and M of each limit."""
        steps, found = self.line.plan.steps, list[ca.SX]()
        for end in self.ends:
            step = next(step for step in steps if end.joint in step.joints)
            found += at.limit_test(step, end.joint, end.value - at.arm.screws[end.joint].zero)
        return found

    @cached_property
    def _expressions(self) -> list[ca.SX]:
        """The functions at half turns and the pose of these."""
        return self._functions(self.line.evaluated())

    @property
    def read_lines(self) -> list[str]:
        """Statements that set the functions' values at joint values; M is negative where the branch
        is the other one.
        """
        at, steps, zero = self.line.evaluated(), self.line.plan.steps, self.line.real.literal(0.0)
        limited = {end.joint for end in self.ends}
        choices = [
            i
            for i, step in enumerate(steps)
            if step.branch is not None and limited & set(step.joints)
        ]
        slopes = [at.slope(steps[i]) for i in choices]
        emitter = self.line.emitter(ca.vertcat(*self._expressions, *slopes))
        texts = [emitter.value(0, k) for k in range(2 * len(self.ends))]
        sides = {i: emitter.value(0, 2 * len(self.ends) + k) for k, i in enumerate(choices)}
        for k, end in enumerate(self.ends):
            i = next(i for i, step in enumerate(steps) if end.joint in step.joints)
            first, other = texts[2 * k : 2 * k + 2]
            emitter.lines.append(f"at[{2 * k}] = {first};")
            if i in sides:
                other = (
                    f"(({sides[i]} < {zero}) ? -{self.line.real.literal(1.0)} : "
                    f"{self.line.real.literal(1.0)}) * {other}"
                )
            emitter.lines.append(f"at[{2 * k + 1}] = {other};")
        return emitter.lines

    @property
    def test_lines(self) -> list[str]:
        """Statements that blame the first joint whose limit is not proved to be kept."""
        bounds = self.line.bounds(self._functions)
        p, count, zero = (
            self.line.code.values["p"],
            f"{len(self.line.plan.arm)}U",
            self.line.real.literal(0.0),
        )
        lines = []
        for k, end in enumerate(self.ends):
            e, m = 2 * k, 2 * k + 1
            side, reads = ("above", "upper") if end.is_upper else ("below", "lower")
            conditions = [
                f"(joint == {count})",
                f"{p}_may_reach({side}[{end.joint}], way2)",
                f"!{p}_keeps_sign(at_a[{e}], at_b[{e}], {self._sum_of(bounds[e])})",
            ]
            # where it is positive always there is no other solution
            if not (self._expressions[m].is_constant() and float(self._expressions[m]) == 1.0):
                other = f"{p}_keeps_sign(at_a[{m}], at_b[{m}], {self._sum_of(bounds[m])})"
                conditions.append(f"!((at_a[{m}] < {zero}) && {other})")
            lines += [
                f"/* {c_comment(self.line.plan.arm.screws[end.joint].name)}, {reads} limit */",
                "if (" + "\n    && ".join(conditions) + ") {",
                f"    joint = {end.joint}U;",
                "}",
            ]
        return lines

    def _sum_of(self, bound: Bound) -> str:
        """C text of 2 K."""
        literal = self.line.real.literal
        terms = [
            f"{literal(rounded_up(w))} * change[{i}]"
            for i, w in enumerate(2.0 * bound.plain)
            if w > 0.0
        ]
        return " + ".join(terms) or literal(0.0)
