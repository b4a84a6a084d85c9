"""Validate the shape of a mechanism file (format 1) by pydantic models; the model's own classes
check what it means.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo
from pydantic_core import PydanticCustomError

from symkin.errors import MechanismError
from symkin.model.arithmetic import evaluate
from symkin.model.names import name_fault, text_fault


def _number(value: Any, info: ValidationInfo) -> float:
    """A finite number, or a string of arithmetic."""
    if isinstance(value, str):
        unit = info.context.get("angle_unit", "deg") if info.context else "deg"
        try:
            return evaluate(value, unit)
        except MechanismError as error:
            raise PydanticCustomError("arithmetic", "{reason}", {"reason": str(error)}) from None
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise PydanticCustomError("number", "a number or a string of arithmetic is needed")
    try:
        number = float(value)
    except OverflowError:
        number = float("inf")
    if not abs(number) < float("inf"):
        raise PydanticCustomError("finite", "a finite number is needed")
    return number


Number = Annotated[float, BeforeValidator(_number)]
Vector = Annotated[list[Number], Field(min_length=3, max_length=3)]
Links = Annotated[list[str], Field(min_length=2, max_length=2)]
Range = Annotated[list[Number], Field(min_length=2, max_length=2)]


def _without(fault: Callable[[object], str | None]) -> AfterValidator:
    """A text in which nothing is wrong."""

    def checked(text: str) -> str:
        reason = fault(text)
        if reason is not None:
            raise PydanticCustomError("text", "{reason}", {"reason": reason})
        return text

    return AfterValidator(checked)


Name = Annotated[str, _without(name_fault)]
Text = Annotated[str, _without(text_fault)]


def _whole(value: Any) -> Any:
    """A whole number as such: neither 1.0 nor true."""
    if type(value) is not int:
        raise PydanticCustomError("format", "the whole number 1 is needed")
    return value


class Table(BaseModel):
    """A TOML table without unknown keys."""

    model_config = ConfigDict(extra="forbid", strict=True)


class MotorTable(Table):
    effort: Range | None = None
    speed: Number | None = None
    armature: Number | None = None


class JointKeys(Table):
    """Keys that joints of limbs, of serial arms and of graphs have in common."""

    name: Name
    point: Vector | None = None
    axis: Vector | None = None
    axis2: Vector | None = None
    pitch: Number = 0.0
    actuated: bool | None = None
    zero: Number = 0.0
    limits: Range | None = None
    motor: MotorTable | None = None


class JointTable(JointKeys):
    type: Literal["R", "P", "H", "C", "U", "S"]


class LinkJointTable(JointKeys):
    """A joint at the top of a file: with `links` one of a graph, without a serial arm's."""

    type: Literal["R", "P", "H", "C", "U", "S", "weld"]
    links: Links | None = None


class LinkRodTable(Table):
    name: Name
    links: Links
    from_: Vector = Field(alias="from")
    to: Vector
    length: Number | None = None
    actuated: bool = False
    offset: Number = 0.0
    limits: Range | None = None


class CouplingTable(Table):
    joint: Name
    of: dict[str, Number] | Name
    offset: Number = 0.0
    polynomial: list[Number] | None = None


class LinkTable(Table):
    name: Name
    points: dict[str, Vector] = {}


class RodTable(Table):
    from_: Vector = Field(alias="from")
    platform: Vector
    length: Number | None = None


class RodLimbTable(Table):
    name: Name
    type: Literal["SPS", "UPS", "SPU"]
    base: Vector
    platform: Vector
    offset: Number = 0.0
    limits: Range | None = None
    links: Links = ["base", "platform"]


class JointLimbTable(Table):
    name: Name
    joint: list[JointTable] = Field(min_length=1)
    rod: list[RodTable] = []
    links: Links = ["base", "platform"]


class FrameTable(Table):
    position: Vector
    quaternion: Annotated[list[Number], Field(min_length=4, max_length=4)] = [1.0, 0.0, 0.0, 0.0]


class PlatformTable(FrameTable):
    link: Name | None = None
    position: Vector = [0.0, 0.0, 0.0]
    motion: Literal["spatial", "schoenflies", "planar", "translation", "spherical"] = "spatial"


class DHRowTable(Table):
    name: Name | None = None
    type: Literal["R", "P"]
    theta: Number = 0.0
    d: Number = 0.0
    a: Number = 0.0
    alpha: Number = 0.0
    limits: Range | None = None


class DHTableTable(Table):
    convention: Literal["standard", "modified"]
    rows: list[DHRowTable] = Field(min_length=1)


class ExampleTable(Table):
    joints: list[Number] | None = None
    pose: Annotated[list[Number], Field(min_length=7, max_length=7)] | None = None
    given: dict[str, Number] | None = None
    start: list[Number] | None = None


class MechanismTable(Table):
    format: Annotated[Literal[1], BeforeValidator(_whole)]
    name: str
    title: Text = ""
    source: Text = ""
    length_unit: Literal["m", "mm"]
    angle_unit: Literal["deg", "rad"]
    limb: list[dict[str, Any]] = []
    platform: PlatformTable | None = None
    dh: DHTableTable | None = None
    joint: list[LinkJointTable] = []
    rod: list[LinkRodTable] = []
    coupling: list[CouplingTable] = []
    link: list[LinkTable] = []
    tool: FrameTable | None = None
    example: ExampleTable | None = None
