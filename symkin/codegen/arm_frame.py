"""Write the border of an arm whose own frame, in which its numbers are simplest, is turned from the
described one: poses and twists are turned there, and all other functions are of the own frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca

from symkin.codegen.steps.geometry import exact_turn
from symkin.codegen.text.c import Emitter, Real, if_ok, indexed
from symkin.codegen.text.templates import fill
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import multiply


def unturned() -> dict[str, object]:
    """What the templates ask of an arm that stands as it is described."""
    nothing = dict.fromkeys(("taken", "told", "static_own", "in_own", "twist_taken"), "")
    return {**nothing, "own_jacobian": "name_jacobian", "given": "twist"}


@dataclass(frozen=True, eq=False)
class ArmFrame:
    """The turn of the described frame into an arm's own, `base`; `values` are counts of
    joints and of entries of the Jacobian.
    """

    base: Pose
    real: Real
    values: Mapping[str, object]

    @property
    def names(self) -> dict[str, object]:
        """Values of names in the templates: statements that turn a pose x or a twist."""
        return {
            "taken": if_ok(self._pose_lines(self.base)),
            "told": self._pose_lines(self.base.inverse()),
            "static_own": "static ",
            "in_own": ", in the arm's own frame",
            "own_jacobian": "name_own_jacobian",
            "given": "own",
            "twist_taken": [
                "real own[6];",
                *self._twist_lines(self.base, indexed("twist", 6), indexed("own", 6)),
            ],
        }

    @property
    def jacobian(self) -> str:
        """NAME_jacobian: the columns of the own one, turned."""
        nq = int(str(self.values["nq"]))
        a, b = ([f"{name}[{nq * i}]" for i in range(6)] for name in "ab")
        shown = {
            "about": "Twist of the tool by joint rates",
            "part": "jacobian",
            "own": "name_own_jacobian",
            "takes": f"const real joints[{nq}]",
            "passed": "joints",
            "found": "jacobian",
            "count": nq,
            "next": 1,
            "turned_row": self._twist_lines(self.base.inverse(), a, b),
        }
        return fill("turned.c", {**self.values, **shown})

    def _pose_lines(self, turn: Pose) -> list[str]:
        x = ca.SX.sym("x", 7)
        quaternion = multiply(ca.DM(exact_turn(turn.quaternion)), x[3:])
        turned = ca.vertcat(ca.mtimes(ca.DM(exact_turn(turn.rotation)), x[:3]), quaternion)
        return Emitter.of(self.real, [(x, "x")], turned).stored("x")

    def _twist_lines(self, turn: Pose, given: list[str], found: list[str]) -> list[str]:
        a, rotation = ca.SX.sym("a", 6), ca.DM(exact_turn(turn.rotation))
        turned = ca.vertcat(ca.mtimes(rotation, a[:3]), ca.mtimes(rotation, a[3:]))
        return Emitter.of(self.real, [(a, given)], turned).stored(found)
