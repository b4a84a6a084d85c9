"""List the functions of generated C, each once: what it takes and gives, and what it is for. From
this table come the declarations of NAME.h, the functions of NAME.hpp and the calls of NAME_test.c.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod

from symkin.codegen.text.templates import substitute
from symkin.computed_once import cached_property

_JOINTS, _FOUND = "NAME_JOINTS", "NAME_FOUND"
_COUNTS = {
    **dict.fromkeys(("joints", "rates", "rate_limits"), _JOINTS),
    **dict.fromkeys(("joint_rates", "joint_torques", "joint_inertias", "joint_limits"), _JOINTS),
    **dict.fromkeys(("found", "found_rates", "found_torques", "found_limits"), _FOUND),
    **dict.fromkeys(("pose", "from", "to"), ""),
    "twist": "6",
    "feed": "1",
    "branch": "number",
    "platform_jacobian": f"{_JOINTS} * 6",
    "arm_jacobian": f"6 * {_JOINTS}",
    "map_jacobian": f"{_FOUND} * {_JOINTS}",
    "inverse_jacobian": f"{_JOINTS} * {_FOUND}",
    "inertia": f"{_FOUND} * {_FOUND}",
    "second": f"{_FOUND} * {_JOINTS} * {_JOINTS}",
}
"""How many numbers arguments have, as C says it: "" of a pose, "1" of one number that is written,
"number" of a whole one.
"""
_TYPES = {
    _JOINTS: "joint_values",
    _FOUND: "joint_values",
    "6": "twist_values",
    "": "pose",
    "1": "real",
    "number": "unsigned int",
}
"""Types of C++ by these; others are matrices."""


@dataclass(frozen=True)
class Value:
    """An argument that is a pose or numbers; `count` as in _COUNTS."""

    name: str
    count: str

    @staticmethod
    def read(text: str) -> Value:
        """Of its name, with what it is like where that tells more: `guess: pose`."""
        name, _, like = text.partition(": ")
        return Value(name, _COUNTS[like or name])

    def declared(self, *, given: bool) -> str:
        """As a parameter in C, that is read where it is `given`."""
        const = "const " if given else ""
        match self.count:
            case "":
                return f"{const}name_pose *{self.name}"
            case "1":
                return f"name_real *{self.name}"
            case "number":
                return f"unsigned int {self.name}"
        return f"{const}name_real {self.name}[{self.count}]"

    @property
    def type(self) -> str:
        """In C++."""
        return _TYPES.get(self.count, "matrix")

    def numbers(self, joints: int) -> int:
        """How many real numbers it has, on a machine of so many joints."""
        if self.count == "number":
            return 0
        factors = re.findall(r"[^ *]+", self.count)
        return prod(int(f) if f.isdigit() else joints for f in factors) if factors else 7


@dataclass(frozen=True)
class Function:
    """A function: its arguments in C's order, `takes -> gives` with config and info among them, and
    in words what it does. What it gives is where it begins if `moves`; `before` stands above it.
    """

    name: str
    arguments: str
    about: str = ""
    moves: bool = False
    before: str = ""

    def _side(self, k: int) -> list[str]:
        sides = self.arguments.split(" -> ")
        return [part for part in sides[k].split(", ") if part] if k < len(sides) else []

    @cached_property
    def takes(self) -> tuple[Value, ...]:
        """What it reads, beside a config."""
        return tuple(Value.read(part) for part in self._side(0) if part != "config")

    @cached_property
    def gives(self) -> tuple[Value, ...]:
        """What it writes, beside an info."""
        return tuple(Value.read(part) for part in self._side(1) if part != "info")

    @property
    def config(self) -> bool:
        return "config" in self._side(0)

    @property
    def info(self) -> bool:
        return "info" in self._side(1)

    def prototype(self) -> str:
        """Its declaration in C."""
        parts = [
            *(["const name_config *config"] if self.config else []),
            *(value.declared(given=True) for value in self.takes),
            *(value.declared(given=False) for value in self.gives),
            *(["name_info *info"] if self.info else []),
        ]
        return f"name_status name_{self.name}(@{{gpd}}{', '.join(parts)});"


_LIMIT = "#define NAME_TRACK_LIMIT ((name_real)@{track_limit}) /* @{unit} */"

PLATFORM = (
    Function(
        "direct",
        "config, joints, guess: pose -> pose, info",
        "The pose that the machine reaches from `guess` when its joints move in a straight "
        "line from the guess's joint values to the given ones without meeting a "
        "singularity; where that is not assured, NAME_WRONG_BRANCH. The guess need not fit "
        "any joint values that were read: an error of it moves the beginning of the line by"
        " as much. @{guess_precision}",
    ),
    Function(
        "track",
        "joints -> pose, info",
        "For servo loops: @{track_words}",
        moves=True,
        before=_LIMIT,
    ),
    Function(
        "inverse",
        "pose -> joints",
        "Joint values of a pose.",
    ),
    Function(
        "jacobian",
        "pose -> jacobian: platform_jacobian",
        "Row-major @{nq} x 6: joint rates = jacobian * (velocity of the platform's origin, "
        "angular velocity).",
    ),
)
LINE = Function(
    "line",
    "config, from, to -> info",
    "Whether the joints keep their limits while the platform goes from one pose to "
    "another in a straight line: its position linearly, its quaternion as q0 + t (q1 - "
    "q0) over its length, the shortest turn. NAME_OK: they do, at all points; by "
    "bounds, not by samples. NAME_OUT_OF_RANGE: the joint info->joint leaves its "
    "limits, or comes so near that this is not decided (NAME_JOINTS: a pose cannot be "
    "taken). Of a config max_iterations is read: the parts that are looked at, "
    "info->iterations. info->residual is 0 with NAME_OK. Singularities are not looked "
    "for.",
)
PLATFORM_SPEEDS = (
    Function(
        "rates",
        "pose, twist -> rates",
        "Joint rates of a twist (velocity of the platform's origin, angular velocity) at a "
        "pose.@{left_out} Speeds above @{fastest_text} are NAME_OUT_OF_RANGE.",
    ),
    Function(
        "twist",
        "pose, rates -> twist",
        "The twist of joint rates at a pose; NAME_SINGULAR where they do not decide it.",
    ),
    Function(
        "feed",
        "pose, twist, rate_limits -> feed",
        "The largest factor, 0 to 1, by which a twist keeps every joint rate within its "
        "limit (0 or more, in @{unit} or radians for each unit of time).",
    ),
)
ARM = (
    Function(
        "direct",
        "joints -> pose",
        "Tool pose of joint values; its quaternion has w >= 0.",
    ),
    Function(
        "inverse",
        "config, pose, guess: joints -> joints, info",
        "The joint values that the arm reaches from `guess` when its tool moves from the "
        "guess's pose to the given one, positions in a straight line and orientations along"
        " the shorter arc, without meeting a singularity; where that is not assured, "
        "NAME_WRONG_BRANCH. Angles are near the guess's, not wrapped. Any joint values will"
        " do as a guess: an error of them moves the beginning of the line by as much. "
        "@{meaning} @{line_words}",
    ),
)
CLOSED_ARM = (
    Function(
        "inverse_branch",
        "pose, branch -> joints",
        "The joint values of one branch. NAME_OUT_OF_RANGE where it has none, NAME_SINGULAR"
        " where nothing decides a joint.",
        before="@{branches_told}",
    ),
    Function(
        "inverse_nearest",
        "pose, guess: joints -> joints",
        "The joint values nearest to the guess, one choice after the other, angles near the"
        " guess's. Whether the arm can move there from the guess is not asked: name_inverse"
        " does. Statuses as of name_inverse_branch.",
    ),
)
ARM_SPEEDS = (
    Function(
        "jacobian",
        "joints -> jacobian: arm_jacobian",
        "Row-major 6 x @{nq}: (velocity of the tool's origin, angular velocity) = jacobian "
        "* joint rates.",
    ),
    Function(
        "rates",
        "joints, twist -> rates, info",
        "Joint rates whose twist is next to the given one (velocity of the tool's origin, "
        "angular velocity): of the shortest, and damped where the arm is near a "
        "singularity, that is where info->min_pivot is below @{damped_below}. "
        "info->residual is how far the twist of these rates is from the given one (@{unit} "
        "for each unit of time, angles times the size): a loop that must keep to its path "
        "slows down or stops by it. Speeds above @{fastest_text} are NAME_OUT_OF_RANGE.",
    ),
    Function(
        "twist",
        "joints, rates -> twist",
        "The twist of joint rates.",
    ),
    Function(
        "feed",
        "joints, twist, rate_limits -> feed",
        "The largest factor, 0 to 1, by which a twist keeps the rates of name_rates within "
        "their limits (0 or more, in @{unit} or radians for each unit of time).",
    ),
    Function(
        "track",
        "pose -> joints, info",
        "For a control loop: one damped step from the last joint values (joints) towards "
        "the pose, which becomes the next ones. It goes on through and beside "
        "singularities, where the arm cannot follow every pose: NAME_OK says that the joint"
        " values are within their ranges, and info->residual how far their tool pose is "
        "from the given one, as measured (@{unit}, angles times the size). While it is "
        "below NAME_TRACK_LIMIT the next step reaches an unmoved pose; farther away steps "
        "are cut to @{most_turn} rad (slides: of the size). It never makes the error "
        "larger.",
        moves=True,
        before=_LIMIT,
    ),
)
MAP = (
    Function(
        "direct",
        "config, joints, guess: found -> found, info",
        "The found values that the machine reaches from `guess` when its joints move in a "
        "straight line from their values at the guess to the given ones, each point of it "
        "real and regular; where that is not assured, NAME_WRONG_BRANCH. Angles are near "
        "the guess's, not wrapped. @{passive_note}",
        before="#define NAME_FOUND (@{nq})",
    ),
    Function(
        "inverse",
        "config, found, guess: joints -> joints, info",
        "The other way: the joints that the machine reaches from `guess` when the found "
        "coordinates move in a straight line from their values at the guess to the given "
        "ones.",
    ),
    Function(
        "track",
        "joints -> found, info",
        "For servo loops: one step from the last found values to those of the joints, and "
        "from the last joints to those of the found values. info->residual is the predicted"
        " error: up to NAME_TRACK_LIMIT another call with the same values brings it below "
        "the tolerance; beyond it, and where a step is not small (NAME_WRONG_BRANCH), call "
        "the function above. No line is checked.",
        moves=True,
        before=_LIMIT,
    ),
    Function(
        "track_inverse",
        "found -> joints, info",
        moves=True,
    ),
    Function(
        "jacobian",
        "joints, found -> jacobian: map_jacobian",
        "Row-major @{nq} x @{nq}: found rates = jacobian * joint rates, where joints and "
        "found belong together.",
    ),
    Function(
        "rates",
        "joints, found, joint_rates -> found_rates",
        "found_rates = jacobian * joint_rates.",
    ),
    Function(
        "torques",
        "joints, found, found_torques -> joint_torques",
        "joint_torques = transposed jacobian * found_torques: the joints' torques (of "
        "slides, forces) that hold those of the found ones.",
    ),
    Function(
        "inverse_jacobian",
        "joints, found -> inverse_jacobian",
        "joint rates = inverse_jacobian * found rates.",
    ),
    Function(
        "second",
        "joints, found -> jacobian: map_jacobian, second",
        "The Jacobian, which may be NULL, and second[(i * NAME_JOINTS + j) * NAME_JOINTS + "
        "k], the second derivative of found i by joints j and k: found accelerations = "
        "jacobian * joint accelerations + sum of second * joint_rates[j] * joint_rates[k].",
    ),
    Function(
        "inertia",
        "joints, found, joint_inertias -> inertia",
        "Row-major: what the joints' inertias (of slides, masses) are at the found "
        "coordinates, G^T joint_inertias G with the inverse Jacobian G.",
    ),
    Function(
        "torque_limits",
        "joints, found, joint_limits -> found_limits",
        "The largest torque, and the largest rate, of each found coordinate alone, the "
        "others without any, for which no joint is beyond its own; @{largest} where no "
        "joint bounds it.",
    ),
    Function(
        "rate_limits",
        "joints, found, joint_limits -> found_limits",
    ),
)


def declarations(functions: Sequence[Function], values: Mapping[str, object]) -> str:
    """Write the declarations of NAME.h; a function without words stands below the one before."""
    blocks: list[str] = []
    for function in functions:
        words = " ".join(substitute(function.about, values).split())
        declared = substitute(function.prototype(), values)
        if function.before:
            blocks.append(substitute(function.before, values))
        if words:
            blocks.append(f"/* {words} */\n{declared}")
        else:
            blocks[-1] += f"\n{declared}"
    return "\n\n".join(blocks) + "\n"
