"""Write the C of a parallel mechanism of any limbs: limbs for a pose, direct problem, inverse,
Jacobian.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.codegen.closed_direct_source import ClosedDirectSource
from symkin.codegen.closed_limb import BESIDE, branch_text
from symkin.codegen.line_parts import FIRST_TURN
from symkin.codegen.map.limb_platform import LimbPlatform
from symkin.codegen.map.limb_source import LimbSource
from symkin.codegen.map.platform_rates import (
    closure_twist,
    decides_twist,
    direct_target,
    fastest,
    speeds_text,
    square_twist,
)
from symkin.codegen.map.record import Source
from symkin.codegen.steps.formula_guards import feasible_error
from symkin.codegen.steps.guard_text import Watched
from symkin.codegen.steps.guards import DETERMINANT
from symkin.codegen.steps.joint_ranges import range_functions, ranges_of
from symkin.codegen.steps.linear_solver import singular_condition
from symkin.codegen.steps.newton_kernel import rounded
from symkin.codegen.steps.newton_source import NewtonCode, tracked_error
from symkin.codegen.steps.passive_limits import limit_lines, texts_of
from symkin.codegen.steps.pose_coordinates import COLUMNS, pose_coordinates_text, pose_text
from symkin.codegen.text.c import Emitter, block, if_ok, refused
from symkin.codegen.text.templates import common_values, copy, farthest, fill, normalise_pose
from symkin.computed_once import cached_property
from symkin.numeric.system import System

_UNIT = 16.0
"""Roundings by which the squared length of a quaternion that is an answer itself may be off."""
_WRITTEN = "name_write_pose(GEOMETRY &w, pose);"
"""The statement that writes what is found."""
_READ = ["(void)name_read_guess(GEOMETRY &w, joints, guess);"]
"""The statement that goes back to the guess."""
_TRACKED = 4.0
"""How many times the error that one step of tracking may predict rows of a guess may be off."""


@dataclass(frozen=True, eq=False)
class LimbPlatformSource(Source):
    """The C of one mechanism, function by function."""

    made: LimbPlatform

    @cached_property
    def _limbs(self) -> list[LimbSource]:
        """The C of each limb."""
        return [LimbSource(self.made, block, self._common) for block in self.made.blocks]

    @property
    def watched(self) -> dict[str, Watched]:
        """What the direct problem watches along lines."""
        found = self.made.direct_formulas
        guards = (DETERMINANT,) if found is None else found.guards
        return {"direct": ([c.name for c in self.made.actuated], guards)}

    @property
    def text(self) -> str:
        """Everything of NAME.c between its beginning and end."""
        values = self.values
        parts = [
            *self._at_pose,
            *self._direct,
            "\n",
            *self._inverse,
            self._in_frame("jacobian"),
            speeds_text("rates", "pose", values),
            self._twist,
            self._in_frame("twist"),
        ]
        body = "".join(parts)
        begin = normalise_pose(values) + fill("info.c", values)
        return begin + self.turning(body, values) + body

    @property
    def _at_pose(self) -> list[str]:
        """What is asked of a pose: its coordinates, joints within limits, the limbs."""
        made, real, values = self.made, self.real, self.values
        ranges = ranges_of(made.actuated, real, made.size)
        return [
            pose_coordinates_text(made.geometry, real, values),
            "" if made.direct_formulas is not None else pose_text(made.geometry, real, values),
            range_functions(ranges, real, values),
            *(limb.text for limb in self._limbs),
            self._solve_limbs,
            self._check_passive,
        ]

    @property
    def _direct(self) -> list[str]:
        """The direct problem: by formulas where there are some, else by Newton's method."""
        found = self.made.direct_formulas
        if found is not None:
            return [
                fill("no_step.c", self._common),
                ClosedDirectSource(self.made, found, self._common).text,
            ]
        return [
            self.code.text,
            self._check_branch,
            fill("no_step.c", self._common),
            fill("parallel_direct.c", self.values),
        ]

    @cached_property
    def code(self) -> NewtonCode:
        """The Newton iteration of the direct problem."""
        made = self.made
        matrices, kappa = made.sampled_direct
        return NewtonCode(
            kernel=made.direct_kernel,
            name=self.name,
            real=self.real,
            geometry=made.geometry.names,
            matrices=matrices,
            kappa=kappa,
            target_lines=self._target_lines,
            known_count=len(made.actuated),
            first_turn=FIRST_TURN,
            compact=made.options.compact,
            **self._driver,
        )

    @property
    def _target_lines(self) -> list[str]:
        """Statements that aim the direct problem at a point of the joints' line."""
        return direct_target(self.made)

    @property
    def _driver(self) -> dict[str, Any]:
        """What Newton's method of the direct problem has of its own."""
        kept = self._keeps_known
        return {"measured": True, "keeps_known": kept, "makes_known": kept}

    @property
    def _keeps_known(self) -> bool:
        """Whether the matrix reads known values, which are dear: they are kept at the part of the
        line that is done.
        """
        return self.made.core is not None and self.made.direct_kernel.reads_known

    @cached_property
    def _common(self) -> dict[str, object]:
        """Values of the names that templates of the limbs need."""
        made = self.made
        return common_values(self.name, self.real, struct=made.geometry.at_run_time) | {
            "nq": len(made.actuated),
            "ns": made.direct_kernel.state.shape[0],
            "nc": sum(c.width for c in made.closure.role("pose")),
            "np": max(1, sum(c.width for c in made.passive)),
            "farthest": farthest(made.size, made.middle),
            "largest": fastest(made.size),
            **self._passive_checks,
            "within": ", real within" if self._checks_rows else "",
            **self._names,
            "feasible": self._within(self._feasible),
        }

    @property
    def _names(self) -> dict[str, str]:
        """The functions of rates in the machine's own frame: those that are called, or parts of
        them where the base frame is another one.
        """
        if self.made.frames is None:
            return {}
        names = {part: f"name_own_{part}" for part in ("jacobian", "twist")}
        return {**names, "static_own": "static "}

    def _in_frame(self, part: str) -> str:
        """The function of rates in the base frame, where this is not the machine's own."""
        rotation, columns = self.made.geometry.rotation, COLUMNS[self.made.mechanism.motion]
        if rotation is None:
            return ""
        lines = list[str]()
        for k in range(6):
            own = [(c, float(rotation[c % 3, k % 3])) for c in columns if c // 3 == k // 3]
            terms = [f"{v} * a[{c}]" for c, v in own if v != 0.0]
            lines.append(f"b[{k}] = {' + '.join(terms) or '0.0'};")
        nq, twist = self._common["nq"], part == "twist"
        shown = {
            "about": "The twist of joint rates" if twist else "Joint rates by the platform's twist",
            "part": part,
            "own": self._names[part],
            "takes": "const name_pose *pose" + f", const real rates[{nq}]" * twist,
            "passed": "pose, rates" if twist else "pose",
            "found": part if twist else "rates",
            "count": 1 if twist else nq,
            "next": 6,
            "turned_row": lines,
        }
        return fill("turned.c", self._common | shown)

    @property
    def _passive_checks(self) -> dict[str, Sequence[str]]:
        """Statements that hold joints which are not actuated against their limits, or ask whether
        they exist: of an inverse, of Newton's method, of formulas.
        """
        write, check = "name_write_pose(GEOMETRY &w, pose);", "name_check_passive(GEOMETRY "
        if not self.made.passive_checks:
            names = ("inverse_passive", "direct_passive", "standing_passive", "check_answer")
            return dict.fromkeys(names, "") | {"write_tracked": [write]}

        count = sum(c.width for c in self.made.passive)
        moves, stands = (", false", ", true") if self._stands else ("", "")
        of_state = f"status = {check}&w.x[{count}], given, w.x{{}});"
        return {
            "inverse_passive": if_ok([f"status = {check}c, q, passive{moves});"]),
            "direct_passive": if_ok([of_state.format(moves)]),
            "standing_passive": if_ok([of_state.format(stands)]),
            "write_tracked": [of_state.format(moves), *if_ok([write])],
            "check_answer": if_ok(["status = name_check_answer(&answer);"]),
        }

    @property
    def _stands(self) -> bool:
        """Whether a guess that is the answer is asked for the limits of its passive joints once
        more: formulas give the same pose from any guess.
        """
        own = self.made.direct_formulas is None
        return own and any(c.still != c.condition for c in self.made.passive_checks)

    @property
    def _checks_rows(self) -> bool:
        """Whether the formulas of a limb leave rows over."""
        return any(block.is_checked for block in self.made.blocks)

    @property
    def _feasible(self) -> float:
        return feasible_error(self.real.epsilon, self.made.size)

    @property
    def _guess_error(self) -> float:
        """Largest closure error of a guess, which may be what one step of tracking has left."""
        return max(
            self._feasible,
            _TRACKED * tracked_error(self.code.tuning, self.made.size),
        )

    def _within(self, error: float) -> str:
        """An argument of NAME_solve_limbs: how far rows may be off."""
        return f", {rounded(error)}" if self._checks_rows else ""

    @cached_property
    def values(self) -> dict[str, object]:
        """Values of the names in the templates of this kind, the tests and the header."""
        made = self.made
        return self._common | {
            "track_factor": singular_condition(
                made.direct_kernel,
                "name_direct",
                "&w",
                compact=made.options.compact,
            ),
            "kappa": np.sqrt(self.code.tuning.kappa2),
            "track2": (made.size / 24) ** 2,
            "check_branch": "",
            "stand": "",
            "reached": "",
            "written": _WRITTEN,
            "keep_known": "",
            **self._line,
        }

    @property
    def _line(self) -> dict[str, object]:
        """Statements of the line: from the guess, by joints near its own, to the pose; and what is
        asked of the limbs' branches.
        """
        made = self.made
        passive = sum(c.width for c in made.passive)
        check = (
            "check_branch(GEOMETRY w.x, w.at, given)"
            if made.tells_branch
            else f"check_given(GEOMETRY &w.x[{passive}], given)"
        )
        branch = if_ok([f"status = name_{check};"])
        unwrap = [
            f"real given[{self._common['nq']}];",
            *self.unwrapped("given", "joints", "w.at"),
        ]
        known = made.direct_kernel.known.numel()
        return {
            "check_branch": branch if made.has_dead_centres else "",
            **(self._stand_beside if made.has_dead_centres else {"stand": self._stand}),
            "unwrap": unwrap,
            "enter": self._enter(passive),
            "leave": [f"name_pose_from_coordinates(GEOMETRY &w->x[{passive}], pose);"],
            "keep_known": copy("w.k0", "w.k", known) if self._keeps_known else "",
            "to": "given",
            "whole": ", 1.0",
        }

    @property
    def _stand(self) -> str:
        """Statements that take a guess whose own rows vanish for the answer, where a step of
        rounding has left passive joints' limits.
        """
        asked = self._passive_checks["standing_passive"]
        return self.code.stand(_READ, "given", asked) if asked else ""

    @property
    def _stand_beside(self) -> dict[str, object]:
        """The same, where it may have passed a dead centre. Limbs solved for the guess's pose are
        off by the root of its rounding there: what Newton's method has moved by no more than rows
        may be off is the answer too, and stays as it is, which turned into coordinates and back it
        might not.
        """
        made = self.made
        begin = sum(c.width for c in made.passive)
        pose = made.closure.role("pose")
        weights = tuple(1.0 if c.is_length else made.size for c in pose for _ in range(c.width))
        answer = [f"real answer[{len(weights)}];"]
        answer += [f"answer[{i}] = w.x[{begin + i}];" for i in range(len(weights))]
        moved = fill("moved.c", self._common | {"begin": begin, "weights": weights})
        unit = rounded(_UNIT * self.real.epsilon)
        asked = fill("standing.c", self._common | {"unit_error": unit})
        return {
            "reached": ["const bool reached = (status == NAME_OK);", "bool standing = false;"],
            "stand": self.code.stand(_READ, "given", asked, answer=answer, moved=moved),
            "written": block("if (standing)", ["*pose = *guess;"], [_WRITTEN]),
        }

    def _enter(self, passive: int) -> str:
        """Statements that set the state to the guess's: its limbs by its pose, then the pose."""
        own = {
            "of_answer": self._within(self._guess_error),
            "copied": copy("w->x", "passive", passive) if passive else "",
            "turned": self.into_limits("w->at", "joints"),
            "placed": [
                f"w->x[{passive + i}] = c[{i}];" for i in range(int(str(self._common["nc"])))
            ],
        }
        return fill("enter.c", self._common | own)

    # --- limbs ------------------------------------------------------------------------------------

    @property
    def _solve_limbs(self) -> str:
        """NAME_solve_limbs: all limbs for a pose, on the reference's branches."""
        lines = [line for limb in self._limbs for line in limb.joint_lines]
        if self.made.conditions.rows.numel():
            lines += self._condition_lines(self.made.conditions)
        return fill("solve_limbs.c", self._common | {"limbs": lines})

    def _condition_lines(self, conditions: System) -> list[str]:
        """Statements that refuse a pose which violates rows that no joint enters."""
        real, geometry = self.real, self.made.geometry
        inputs = [
            (conditions.known, "c"),
            (geometry.symbols, geometry.names),
        ]
        emitter = Emitter.of(real, inputs, conditions.rows, prefix="v")
        limit = feasible_error(real.epsilon, conditions.characteristic_length)
        tests = [
            f"(fabs({emitter.value(0, i)}) <= {limit})" for i in range(conditions.rows.numel())
        ]
        return [
            "/* what the pose alone must satisfy */",
            *emitter.lines,
            *refused(" && ".join(tests), "OUT_OF_RANGE"),
        ]

    @property
    def _check_passive(self) -> str:
        """NAME_check_passive, where joints that are not actuated have limits, or need not exist."""
        made, closure = self.made, self.made.closure
        if not made.passive_checks:
            return ""
        arrays = {"q": "actuated", "passive": "passive", "c": "pose"}
        texts = (texts_of(array, closure.role(role)) for array, role in arrays.items())
        names = dict(pair for own in texts for pair in own.items())
        variables = [text for c in closure.coordinates for text in names[c.name]]
        lines = limit_lines(
            made.passive_checks,
            variables,
            made.geometry,
            self.real,
            "NAME_OUT_OF_RANGE",
            stands=self._stands,
        )
        still = ", bool still" if self._stands else ""
        asked = "are within their limits" if made.passive_limits else "exist where the rows hold"
        text = fill(
            "check_passive.c", self._common | {"lines": lines, "asked": asked, "still": still}
        )
        if made.direct_formulas is None:
            return text
        return text + fill(
            "check_answer.c", self._common | {"of_answer": self._within(self._guess_error)}
        )

    # --- branches and turns -----------------------------------------------------------------------

    @property
    def _check_branch(self) -> str:
        """NAME_check_given and NAME_check_branch, where a pose may leave limbs more than one way to
        stand. Two ways meet at a dead centre, where errors of the tolerance are their square roots
        in joint values: what differs by less is one.
        """
        made = self.made
        if not made.has_dead_centres:
            return ""
        size = made.size
        # near a dead centre the pose moves by the square of the joint: an error t of the pose is
        # sqrt(t) there
        near = [
            BESIDE * np.sqrt(self.code.tuning.tolerance / size) * (1.0 if c.is_angular else size)
            for c in made.actuated
        ]
        values = self._common | {
            "near": tuple(rounded(v) for v in near),
            "within_given": self.into_limits("q", "given"),
            "turned_given": self.unwrapped("turned", "given", "q"),
        }
        text = fill("check_given.c", values)
        return text + (
            branch_text(made, values, self.code.tuning.tolerance) if made.tells_branch else ""
        )

    # --- inverse and Jacobian ---------------------------------------------------------------------

    @property
    def _inverse(self) -> list[str]:
        """NAME_inverse and NAME_jacobian."""
        lines = [line for limb in self._limbs for line in limb.rate_lines]
        own = {
            "within_middle": self._to_middle,
            "rates": lines,
            "copy_joints": copy("joints", "q", len(self.made.actuated)),
        }
        return [fill("limb_inverse.c", self._common | own), "\n"]

    @property
    def _twist(self) -> str:
        """NAME_twist."""
        if decides_twist(self.made.mechanism):
            return square_twist(self.made.mechanism, self.real, self._common)
        driver = None if self.made.direct_formulas is not None else self.code.kernel
        return closure_twist(self.made, self._common, driver)

    @property
    def _to_middle(self) -> list[str]:
        """Statements that move limited angles into their limits."""
        turned = self.into_limits("q", "middle")
        middles = self.array([0.5 * sum(c.limits or (0.0, 0.0)) for c in self.made.actuated])
        begin = f"static const real middle[{len(self.made.actuated)}] = {{ {middles} }};"
        return [begin, *turned] if turned else []
