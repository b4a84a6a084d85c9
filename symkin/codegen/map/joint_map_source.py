"""Write the C of a map between joints: both directions, one step of each, Jacobian, rates and
torques.
"""

from __future__ import annotations

from dataclasses import dataclass

from symkin.codegen.map.joint_map_rates import LARGEST, rates_text
from symkin.codegen.map.joint_map_values import MapValues
from symkin.codegen.map.map_direction import DirectionSource
from symkin.codegen.steps.guard_text import Watched
from symkin.codegen.steps.joint_ranges import Range, check_text, range_functions, ranges_of
from symkin.codegen.steps.newton_source import NewtonCode
from symkin.codegen.text.angles import number_counts
from symkin.codegen.text.templates import FARTHEST, common_values, farthest, fill
from symkin.codegen.text.turns import angle_of_direction, cosine_and_sine
from symkin.computed_once import cached_property
from symkin.model.joint import units_of


@dataclass(frozen=True, eq=False)
class JointMapSource(MapValues):
    """The C of one map, function by function."""

    @cached_property
    def ways(self) -> tuple[DirectionSource, DirectionSource]:
        """The direct problem and the inverse one."""
        direct, inverse = (
            DirectionSource(self.made, d, self._common)
            for d in (self.made.direct, self.made.inverse)
        )
        return direct, inverse

    @property
    def code(self) -> NewtonCode:
        """Newton's method of the direct problem."""
        return self.ways[0].code

    @property
    def watched(self) -> dict[str, Watched]:
        """What each direction watches along lines."""
        return {way.direction.name: way.watched for way in self.ways}

    @cached_property
    def _common(self) -> dict[str, object]:
        made, literal = self.made, self.literal
        n = len(made.given)
        return common_values(self.name, self.real, struct=False) | {
            "nq": n,
            "nj": n * n,
            "ny": sum(number_counts(made.coordinates)),
            "farthest": literal(farthest(made.size, (0.0, 0.0, 0.0))),
            "largest": literal(LARGEST),
        }

    @cached_property
    def values(self) -> dict[str, object]:
        """Values of the names in the templates of this kind, the tests and the header."""
        note = "What the values leave to other joints is as at the reference configuration."
        return self._common | {"passive_note": note if self.made.passive else ""}

    @property
    def text(self) -> str:
        """Everything of NAME.c between its beginning and end."""
        direct, inverse = self.ways
        body = "".join(
            [
                *(way.solver_text for way in self.ways),
                inverse.state_text,
                direct.state_text,
                *(way.away_text for way in self.ways),
                *(way.text for way in self.ways),
                fill("map_give.c", self._common),
                rates_text(direct, inverse),
            ]
        )
        return fill("info.c", self._common) + self._tools(body) + body

    # --- parts ------------------------------------------------------------------------------------

    def _tools(self, text: str) -> str:
        """The functions of angles that a text calls, and the checks of values."""
        common = self._common
        tools = {
            "angle": angle_of_direction(self.real, common),
            "cosine_and_sine": cosine_and_sine(self.real, common),
        }
        written = [tool for name, tool in tools.items() if f"{self.name}_{name}(" in text]
        turning = self.turning(text, common)
        return "".join([*written, turning, self._checks, fill("no_step.c", common)])

    @property
    def _checks(self) -> str:
        """Checks of joints and of found values: against limits, and of guesses, which need not keep
        to them.
        """
        real, size, common, found = self.real, self.made.size, self._common, list[str]()
        for what, coordinates in self.made.told.items():
            ranges = ranges_of(coordinates, real, size)
            far = [self.literal(FARTHEST * unit) for unit in units_of(coordinates, size)]
            bounds = [Range(f"-{most}", most) for most in far]
            found += [
                range_functions(ranges, real, common)
                if what == "joints"
                else check_text("found values", "ranges", "limit_found", ranges, common),
                check_text(f"{what} of a guess", "bounds", f"bound_{what}", bounds, common),
            ]
        return "".join(found)
