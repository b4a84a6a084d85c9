"""Poses on the command line: seven numbers, or a position and angles."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, TypedDict

from symkin.cli.options import joints_from, named_from, numbers_from
from symkin.cli.streams import say
from symkin.errors import InputError
from symkin.model.oddities import FULL_TURN
from symkin.text import counted
from symkin.verb_options import GIVEN, Option

if TYPE_CHECKING:
    from symkin.model.mechanism import Mechanism
    from symkin.spatial.pose import AngleUnit

EULER = Option(
    "Poses are X,Y,Z,A,B,C with three angles: capitals (ZYX) turn about moving axes, small letters "
    "(xyz, or rpy) about fixed ones.",
    "SEQUENCE",
    GIVEN,
)


class PoseForm(TypedDict):
    """Options that tell how poses are written."""

    rpy: Annotated[
        str | None,
        Option(
            "Roll, pitch, yaw of a pose that is given as X,Y,Z: turns about the fixed axes x, then "
            "y, then z.",
            "R,P,Y",
            GIVEN,
        ),
    ]
    euler: Annotated[str | None, EULER]


UNTOLD: PoseForm = {"rpy": None, "euler": None}

ROLL_PITCH_YAW, _FIXED = "rpy", "xyz"
"""Roll, pitch and yaw, and the Euler sequence that they are: about fixed axes, in this order."""
_QUATERNION, _ANGLES, _POSITION = 7, 6, 3
"""Counts of numbers of a pose with a quaternion, of one with three angles, and of a position."""


@dataclass(frozen=True)
class PoseReader:
    """How the poses of a command are written: `rpy` and `euler` are the options' texts; `has_rpy`:
    the command takes --rpy.
    """

    mechanism: "Mechanism"
    rpy: str | None = None
    euler: str | None = None
    has_rpy: bool = True

    @property
    def unit(self) -> "AngleUnit":
        """The unit of angles."""
        return self.mechanism.angle_unit

    def pose(self, text: str | None, option: str) -> list[float] | None:
        """x, y, z, qw, qx, qy, qz of an option. Raises InputError for a number of values that does
        not fit the other options.
        """
        if self.rpy is not None and self.euler is not None:
            raise InputError("both --rpy and --euler are given; give one of them")
        if self.rpy is not None and text is None:
            raise InputError(f"--rpy is given without a position; write --{option} X,Y,Z beside it")
        numbers = numbers_from(text, option, self.unit)
        if numbers is None:
            return None
        angles = numbers_from(self.rpy, "rpy", self.unit)
        if angles is not None:
            _check_count(numbers, _POSITION, f"--{option}", "X,Y,Z beside --rpy")
            _check_count(angles, 3, "--rpy", "R,P,Y")
            return self._with_angles(numbers, angles, ROLL_PITCH_YAW)
        return self._complete(numbers, f"--{option}")

    def given(self, text: str | None) -> dict[str, float | list[float]] | None:
        """Values by name, of which `pose` may be a whole pose."""
        values = None if text is None else named_from(text, "given", self.unit)
        whole = None if values is None else values.get("pose")
        if values is None or not isinstance(whole, list):
            return values
        return values | {"pose": self._complete(whole, "--given pose")}

    def start(
        self, text: str | None, *, is_pose: bool
    ) -> list[float] | dict[str, float | list[float]] | None:
        """A start: a pose where `is_pose`, else joints, or values by name."""
        begun = joints_from(text, "start", self.unit, whole_pose=True)
        return (
            self._complete(begun, "--start")
            if is_pose and isinstance(begun, list) and self.euler is not None
            else begun
        )

    def check_used(self, *texts: str | None) -> None:
        """Refuse --euler where nothing that it could tell of is given."""
        if self.euler is not None and all(text is None for text in texts):
            raise InputError(
                "--euler tells how the angles of a pose are meant, and no pose is given; leave it "
                "out"
            )

    def _complete(self, numbers: list[float], what: str) -> list[float]:
        """A pose from a position with angles, or for a platform that keeps its orientation from a
        position alone.
        """
        if self.euler is not None:
            _check_count(
                numbers, _ANGLES, what, f"X,Y,Z,A,B,C with the angles of --euler {self.euler}"
            )
            return self._with_angles(numbers[:3], numbers[3:], self.euler)
        if len(numbers) == _POSITION and self.mechanism.motion == "translation":
            return [*numbers, *map(float, self.mechanism.reference_pose.quaternion)]
        if len(numbers) != _QUATERNION:
            rpy = "X,Y,Z --rpy R,P,Y, or " if self.has_rpy else ""
            raise InputError(
                f"{what}: {counted(len(numbers))} given, 7 are needed: x, y, z, qw, qx, qy, qz; "
                f"for angles write {rpy}"
                "X,Y,Z,A,B,C --euler ZYX"
            )
        return numbers

    def _with_angles(
        self, position: list[float], angles: list[float], sequence: str
    ) -> list[float]:
        from symkin.spatial.pose import Pose

        if self.mechanism.angle_unit == "rad" and max(map(abs, angles)) > FULL_TURN:
            largest = max(angles, key=abs)
            say(
                f"note: {largest:g} rad: more than a turn; angles of {self.mechanism.name} are "
                f"radians, as in pi/2. Are degrees meant?"
            )
        letters = _FIXED if sequence == ROLL_PITCH_YAW else sequence
        pose = Pose.from_euler(position, angles, letters, angle_unit=self.unit)
        return [*position, *map(float, pose.quaternion)]


def _check_count(numbers: list[float], count: int, what: str, form: str) -> None:
    if len(numbers) != count:
        raise InputError(f"{what}: {counted(len(numbers))} given, {count} are needed: {form}")
