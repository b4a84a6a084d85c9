"""Write the C that follows an arm's closed form along the line of tool poses from a guess's to the
given one.

Each step of the closed form decides its joints while a square D stays above zero: the step's
discriminant, or the square of the length that is carried, as a function of the tool's pose and the
joints before. Between two points a, b of the line D stays above zero where its second derivative is
below 2 (D_a + D_b) + 4 min(D_a, D_b). `arm_bounds` bounds that derivative by what the tool and the
joints before do on the part; and what these do by the least of their own squares there and by their
ways between the two points. Parts of the line for which this holds are kept, others are cut.

Joints keep their limits between two points of the line: a joint leaves the straight way between its
values there by no more than an eighth of the bound of its second derivative.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from symkin.closed.evaluation import Evaluation
from symkin.closed.plan import Plan
from symkin.codegen.arm_motion import ArmMotion
from symkin.codegen.arm_part import RAISED, HeldPart
from symkin.codegen.closed_source import LEAST, ClosedCode
from symkin.codegen.steps.guard_text import GuardText
from symkin.codegen.steps.guards import Bound, Guard
from symkin.codegen.steps.joint_ranges import standing_range
from symkin.codegen.steps.newton_kernel import rounded, rounded_up
from symkin.codegen.text.c import Emitter, Real
from symkin.codegen.text.templates import copy, fill
from symkin.codegen.text.turns import near_arctangent
from symkin.computed_once import cached_property

_HELPERS = ("take", "least", "least_length", "least_sine", "bounds")
"""Functions that hold squares and bound joints, the first of which others call."""
_NEARLY_ONE = 0.999
"""Share of a discriminant that rounding leaves above zero."""
_LONGER = "part * ((w->bent < {0} * w->most) ? {1} : ({2} * sqrt(w->most / w->bent)))"
"""The next part where one was kept at once: by _GROWS of what would do, at most _LONGEST times as
long. Bounds grow faster than by the square of a part, and a refused point costs as much as a kept
one: of random lines these take fewest points (a fifth fewer than four fifths and 2 did).
"""
_GROWS, _LONGEST = 0.5, 1.3


@dataclass(frozen=True, eq=False)
class ClosedLine:
    """The line check of one arm's closed form."""

    code: ClosedCode
    motion: ArmMotion

    @property
    def plan(self) -> Plan:
        return self.code.plan

    @property
    def real(self) -> Real:
        return self.code.real

    @cached_property
    def _limits(self) -> LimitCheck:
        return limit_check(self.code)

    # --- expressions of joint values --------------------------------------------------------------

    @cached_property
    def _x(self) -> ca.SX:
        return ca.SX.sym("x", 7)

    @cached_property
    def _guards(self) -> ca.SX:
        """Of the guarded steps g, where they have two solutions, else g^2; by the half turns and
        the pose that they lead to.
        """
        at, found = self.evaluated(), []
        for i in self.code.guarded:
            step = self.plan.steps[i]
            if step.branch is not None:
                found.append(at.slope(step) / float(np.sqrt(at.discriminant_scale(step))))
            else:
                found.append(at.decide(step, 1.0).strength)
        return ca.vertcat(ca.SX(0, 1), *found)

    def evaluated(self) -> Evaluation:
        """The arm at the half turns and the pose that they lead to."""
        return replace(
            Evaluation(self.plan.arm, self._x[:3], self._x[3:]), motions=self.motion.motions
        )

    def emitter(self, expressions: ca.SX) -> Emitter:
        """Emitter of functions of the half turns `u` and of the pose `x` that they lead to."""
        return self.motion.emitter(expressions, self._x)

    # --- guards -----------------------------------------------------------------------------------

    @cached_property
    def _held(self) -> HeldPart:
        return HeldPart(self.code, self._limits.joints)

    @cached_property
    def guards(self) -> list[Guard]:
        """The squares of the steps that choose or carry; sizes are of slides within one size."""
        none, bounds, found = np.zeros(0), self._held.bounds, []
        for i in self.code.guarded:
            size = rounded_up(bounds.usual(bounds.at_ends(self._held.steps[i].size), 1.0))
            name = self.plan.steps[i].reason
            told = (Bound(size, none, none, none),)
            found.append(Guard(name, None, (), 1.0, "proved", told))
        return found

    # --- text -------------------------------------------------------------------------------------

    @cached_property
    def _guard_text(self) -> GuardText:
        return GuardText(self.guards, self.real, measures=True)

    @property
    def _read_lines(self) -> list[str]:
        """Statements that set squares, the branch and the joints' pairs."""
        pairs = [e for m in self.motion.motions.values() for e in m.pair]
        emitter = self.emitter(ca.vertcat(self._guards, *pairs))
        choices = [i for i, step in enumerate(self.plan.steps) if step.branch is not None]
        for k, i in enumerate(self.code.guarded):
            emitter.comment(self.plan.steps[i].reason)
            text = emitter.value(0, k)
            square = f"{text} * {text}" if i in choices else text
            emitter.lines.append(f"w->left[{k}] = {square};")
            if i in choices:
                sign = f"({text} < 0.0) ? -1.0 : 1.0"
                emitter.lines.append(f"w->sign[{choices.index(i)}] = {sign};")
        pairs_of = (f"w->turned[{i}][{k}]" for i in range(len(self.plan.arm)) for k in range(2))
        for k, target in enumerate(pairs_of, start=len(self.code.guarded)):
            emitter.lines.append(f"{target} = {emitter.value(0, k)};")
        return emitter.lines

    @property
    def _exact(self) -> list[bool]:
        """Whether each joint's value is exact at all points: slides, and where there are limits."""
        joints = zip(self.plan.arm.screws, self.code.coordinates, strict=True)
        return [screw.slides or c.limits is not None for screw, c in joints]

    @property
    def _way_lines(self) -> list[str]:
        """Statements of the joints' ways between two points, and of their values at the second."""
        lines = list[str]()
        per = f" * {1.0 / self.plan.arm.size}"
        for i, (screw, exact) in enumerate(zip(self.plan.arm.screws, self._exact, strict=True)):
            way = f"name_inverse_turn(w->turned[{i}], w->aimed[{i}])"
            if exact:
                way = f"name_inverse_joint({i}, w->aimed[{i}], w->joints[{i}]) - w->joints[{i}]"
            lines += [
                f"const real way{i} = {way};",
                f"w->found[{i}] = w->joints[{i}] + way{i};",
                f"w->way[{i}] = fabs(way{i}){per * screw.slides};",
            ]
        squares = (f"(w->way[{i}] * w->way[{i}])" for i in range(len(self.plan.arm)))
        return [*lines, f"w->way2 = {' + '.join(squares)};"]

    @property
    def _taken(self) -> list[str]:
        """Statements that take a point where the line is tried for the one where it is done."""
        n = len(self.plan.arm)
        pairs = [f"[{i}][{k}]" for i in range(n) for k in range(2)]
        return [
            *copy("w->joints", "w->found", n),
            *(f"w->turned{place} = w->aimed{place};" for place in pairs),
        ]

    def text(self) -> str:
        """The functions, which need those of the closed form."""
        values, limits, guards = self._values, self._limits, self._guard_text
        names = values | {
            "members": [*guards.members, *limits.members],
            "ways": fill("line_of_poses.c", values),
            "shorter": [*guards.shorter_lines, *limits.shorter],
        }
        walk = guards.text(names, fill("point_of_poses.c", names).split("\n"), 1.0)
        called = walk + limits.text
        helpers = [
            fill(f"closed_{name}.c", names)
            for name in _HELPERS[1:]
            if f"_inverse_{name}(" in called
        ]
        if f"_inverse_{_HELPERS[0]}(" in "".join([called, *helpers]):
            helpers.insert(0, fill(f"closed_{_HELPERS[0]}.c", names))
        own = {"walk": walk, "limits": limits.text, "helpers": "".join(helpers)}
        own["joint"] = fill("closed_joint.c", names)
        if not all(self._exact):
            own["turn_between"] = fill("closed_way.c", names)
        return fill("closed_line.c", names | {"turn_between": ""} | own)

    @property
    def _values(self) -> dict[str, object]:
        """Values of the names in the templates."""
        screws, real = self.plan.arm.screws, self.real
        size = self.plan.arm.size
        numbers = {
            "per_size2": size**-2,
            "size2": size**2,
            "least": LEAST * real.epsilon,
            "sixth": 1.0 / 6.0,
            "turn_noise": 4.0 * real.epsilon,
            "raised": RAISED,
            "nearly_one": _NEARLY_ONE,
        }
        shares = (rounded((_GROWS / _LONGEST) ** 2), _LONGEST, _GROWS)
        longer = _LONGER.format(*map(str, shares))
        beyond = "(reached == NAME_OUT_OF_RANGE) && (end >= 1.0)"
        texts = {
            "k": "name_inverse",
            "nto": 2,
            "nat": 7,
            "turns": 2 * len(screws),
            "zeros": tuple(screw.zero for screw in screws),
            "near_arctangent": near_arctangent(real),
            "walks": "NAME_SHARED",
            "hold_guards": "",
            "read": self._read_lines,
            "reach": self.code.line_body,
            "way_lines": self._way_lines,
            "keep_lines": self._held.lines,
            "aimed": "real most2, ",
            "take": self._taken,
            "longer": longer,
            "and_follows": " && name_inverse_follows(w, most2)",
            "unreached": f"((reached == NAME_SINGULAR) || ({beyond})) ? reached : "
            "NAME_WRONG_BRANCH",
        }
        return self.code.names | numbers | texts | self._limits.names


# --- limits ---------------------------------------------------------------------------------------


_WITHOUT: dict[str, object] = dict.fromkeys(("guess_beyond", "blame", "and_within"), "")


@dataclass(frozen=True)
class LimitCheck:
    """How the line asks whether joints keep their limits: which ones have some, values of names in
    its template, `members` of its work space, statements where a part is `shorter`, and the
    functions that these call.
    """

    joints: tuple[int, ...]
    names: dict[str, object]
    text: str
    members: tuple[str, ...] = ()
    shorter: tuple[str, ...] = ()


def limit_check(code: ClosedCode) -> LimitCheck:
    """The check of an arm's limits along the line; of an arm without limits the plain text."""
    real, p, n = code.real, code.values, len(code.plan.arm)
    count = f"{n}U"
    limited = tuple(i for i, c in enumerate(code.coordinates) if c.limits is not None)
    if not limited:
        plain: dict[str, object] = {
            "limits_kept": "return follows;",
            "refused": "NAME_WRONG_BRANCH",
        }
        return LimitCheck((), _WITHOUT | plain, "")
    beyond = "    status = NAME_OUT_OF_RANGE;"
    names: dict[str, object] = {
        "and_within": ", and the joints keep their limits",
        "guess_beyond": [
            "w->beyond = false;",
            "w->blamed = name_first_beyond(joints);",
            f"if (w->blamed < {count}) {{",
            beyond,
            "}",
        ],
        "limits_kept": [
            "if (follows) {",
            "    w->blamed = name_first_leaving(w, w->joints, w->found);",
            f"    w->beyond = (w->blamed < {count}) && (name_first_beyond(w->found) < {count});",
            "}",
            f"return follows && (w->blamed == {count});",
        ],
        "refused": f"(w->blamed < {count}) ? NAME_OUT_OF_RANGE : NAME_WRONG_BRANCH",
        "blame": [
            "if ((info != NULL) && (status == NAME_OUT_OF_RANGE)) {",
            "    info->joint = w->blamed;",
            "}",
        ],
    }
    # between two points of a line that are within their ranges, which may be one that stands still
    ranges = [standing_range(c, real, code.plan.arm.size) for c in code.coordinates]
    own = {
        "k": "name_inverse",
        "last": n - 1,
        "limited": tuple(c.limits is not None for c in code.coordinates),
        "lows": tuple(low for low, _ in ranges),
        "highs": tuple(high for _, high in ranges),
        "per_lengths": tuple(
            1.0 / code.plan.arm.size if screw.slides else 1.0 for screw in code.plan.arm.screws
        ),
        "nn": n,
        "raised": RAISED,
    }
    members = (
        "uint8_t blamed; /* the joint that leaves its limits */",
        "bool beyond; /* whether it is beyond them where the line is tried */",
    )
    text = fill("closed_limits.c", {**p, **own})
    return LimitCheck(limited, names, text, members, ("if (w->beyond) {", beyond, "}"))
