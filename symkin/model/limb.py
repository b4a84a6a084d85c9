"""Describe limbs: chains of joints from base to platform, rods between spherical ends, and chains
that end in rods.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from symkin.errors import MechanismError
from symkin.model.bar import Bar, RodEnd
from symkin.model.joint import (
    BASE,
    PLATFORM,
    Joint,
    finite,
    interval,
    link_pair,
    vector3,
)
from symkin.spatial.pose import Pose
from symkin.text import not_among

RodType = Literal["SPS", "UPS", "SPU"]
ROD_TYPES: tuple[RodType, ...] = ("SPS", "UPS", "SPU")
LIMB_LINKS = (BASE, PLATFORM)
"""The links of a limb where nothing else is said."""
_SAME_POINT = 1e-9
"""Distance of two points that are one, over their largest coordinate."""


@dataclass(frozen=True)
class RodLimb:
    """An actuated rod between two joint centres: |t + R platform - base| = offset + value, (t, R)
    the platform's pose.

    `base` (3 numbers, base frame) and `platform` (3 numbers, platform frame) are the centres, in
    the length unit. The coordinate `value`, named as the limb, is the length beyond `offset`;
    `limits` (low, high) are a range of that value. SPS, UPS and SPU have the same closure: they
    differ in whether the rod can spin about itself. `links` are those that it joins. Raises
    MechanismError for numbers that are not finite, an empty range and another type.

    >>> import symkin
    >>> leg = symkin.RodLimb("leg1", [0, -275, 0], platform=[-125, -216.5, 0], limits=[100, 400])
    >>> leg.type, leg.base
    ('SPS', (0.0, -275.0, 0.0))

    Source: J.-P. Merlet, Parallel Robots, 2nd ed., 2006, section 3.1.
    """

    name: str
    base: Sequence[float]
    platform: Sequence[float]
    offset: float = 0.0
    limits: Sequence[float] | None = None
    type: RodType = "SPS"
    links: Sequence[str] = LIMB_LINKS

    def __post_init__(self) -> None:
        where = f"limb {self.name!r}"
        object.__setattr__(self, "links", link_pair(self.links, where))
        if self.type not in ROD_TYPES:
            raise MechanismError(f"{where}: type = {not_among(self.type, ROD_TYPES)}")
        object.__setattr__(self, "base", vector3(self.base, f"{where}: base"))
        object.__setattr__(self, "platform", vector3(self.platform, f"{where}: platform"))
        object.__setattr__(self, "offset", finite(self.offset, f"{where}: offset"))
        object.__setattr__(self, "limits", interval(self.limits, f"{where}: limits"))

    @property
    def joints(self) -> tuple[Joint, ...]:
        """None: those of a rod limb are its ends and its length."""
        return ()

    @property
    def links_along(self) -> list[str]:
        """The link that carries the rod."""
        return [self.links[0]]

    def bars(self, platform: Pose) -> tuple[Bar, ...]:
        """The rod, for a reference pose of the platform."""
        start = RodEnd(f"{self.name}.base", tuple(self.base))
        end = RodEnd.of_platform(f"{self.name}.platform", self.platform, platform)
        bar = Bar(self.name, start, end, self.name, offset=self.offset, spins=self.type == "SPS")
        return (bar.driven(self.limits),)


@dataclass(frozen=True)
class Rod:
    """A rigid rod with spherical ends, |platform point - start point| = length, from a limb's last
    link to the platform.

    `start` (3 numbers) is on the last link, in the base frame at the reference configuration;
    `platform` (3 numbers) in the platform frame; `length` (length unit) is that at the reference
    where it is not given. Two of them make the parallelogram of a delta. Raises MechanismError for
    numbers that are not finite and a length that is not positive.

    >>> import symkin
    >>> symkin.Rod(start=[300, 20, -80], platform=[60, 20, 0], length=600).length
    600.0

    Source: R. Clavel, Conception d'un robot parallele rapide a 4 degres de liberte, PhD thesis,
    EPFL, 1991.
    """

    start: Sequence[float]
    platform: Sequence[float]
    length: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", vector3(self.start, "rod: from"))
        object.__setattr__(self, "platform", vector3(self.platform, "rod: platform"))
        if self.length is not None:
            length = finite(self.length, "rod: length")
            if length <= 0.0:
                raise MechanismError(f"rod: length = {length!r} must be positive")
            object.__setattr__(self, "length", length)


@dataclass(frozen=True)
class Limb:
    """Joints in order from base to platform; or, with `rods`, from base to the last link, which
    carries the rods.

    With joint screws S1 ... Sn at the reference and the platform's reference pose M, the limb
    places the platform at exp(S1 q1) ... exp(Sn qn) M. `joints` hold at least one Joint, `rods` any
    number of Rod; `links` are the ones on which the limb begins and ends. Raises MechanismError for
    a limb without a joint, and for two spherical joints at one centre that nothing can part.

    >>> import symkin
    >>> z = [0, 0, 1]
    >>> shoulder = symkin.Joint("shoulder", "R", [0, 0, 0], z, actuated=True)
    >>> symkin.Limb("arm", [shoulder, symkin.Joint("elbow", "R", [120, 0, 0], z)]).type
    'RR'

    Source: R. W. Brockett, Robotic manipulators and the product of exponentials formula, 1984.
    """

    name: str
    joints: Sequence[Joint]
    rods: Sequence[Rod] = ()
    links: Sequence[str] = LIMB_LINKS

    def __post_init__(self) -> None:
        object.__setattr__(self, "links", link_pair(self.links, f"limb {self.name!r}"))
        object.__setattr__(self, "joints", tuple(self.joints))
        object.__setattr__(self, "rods", tuple(self.rods))
        welds = [joint.name for joint in self.joints if joint.type == "weld"]
        if welds:
            raise MechanismError(
                f"limb {self.name!r}: {welds[0]} is a weld, which a limb has not; leave it out"
            )
        if not self.joints:
            raise MechanismError(
                f"limb {self.name!r} has no joint; a limb needs at least one, or the keys of a rod "
                f"limb"
            )
        self._check_balls()

    def _check_balls(self) -> None:
        """Refuse two spherical joints at one centre that nothing between them can part: their
        distance would be zero always.
        """
        balls = [i for i, joint in enumerate(self.joints) if joint.type == "S"]
        if len(balls) < 2:
            return
        first, last = self.joints[balls[0]], self.joints[balls[-1]]
        between = self.joints[balls[0] + 1 : balls[-1]]
        if all(turns_about(joint, first.point) for joint in (*between, last)):
            raise MechanismError(
                f"limb {self.name!r}: the spherical joints {first.name!r} and {last.name!r} lie at "
                f"one point and nothing between "
                "them moves them apart, a rod of no length; leave one of them out"
            )

    def bars(self, platform: Pose) -> tuple[Bar, ...]:
        """The rods at its end."""
        found = []
        for k, rod in enumerate(self.rods, start=1):
            path = f"{self.name}.rod{k}"
            end = RodEnd.of_platform(f"{path}.platform", rod.platform, platform)
            found.append(
                Bar(f"rod {k}", RodEnd(f"{path}.from", tuple(rod.start)), end, path, rod.length)
            )
        return tuple(found)

    @property
    def links_along(self) -> list[str]:
        """The links in order: the first, those between the joints (leg1.1, leg1.2, ...), and behind
        the last joint the last or the one that carries the rods.
        """
        first, last = self.links
        inner = len(self.joints) - (0 if self.rods else 1)
        between = [f"{self.name}.{k}" for k in range(1, inner + 1)]
        return [first, *between, *([] if self.rods else [last])]

    @property
    def type(self) -> str:
        """Letters of the joints from base to platform, and the count of rods: RUS, R+2SS."""
        return "".join(joint.type for joint in self.joints) + (
            "" if not self.rods else f"+{len(self.rods)}SS"
        )


AnyLimb: TypeAlias = Limb | RodLimb
"""What has `joints` in order from the base, `links_along` them, and `bars` at its end: of a rod
limb no joint and one bar.
"""


def turns_about(joint: Joint, centre: Sequence[float]) -> bool:
    """Whether a joint leaves a point at rest that lies on its axes."""
    if joint.type == "R":
        away = np.cross(np.subtract(joint.point, centre), np.array(joint.axis))
        return float(np.linalg.norm(away)) <= _same_point(joint.point, centre)
    return joint.type in "US" and coincide(joint.point, centre)


def coincide(a: Sequence[float], b: Sequence[float]) -> bool:
    """Whether two points are one to rounding."""
    return float(np.linalg.norm(np.subtract(a, b))) <= _same_point(a, b)


def _same_point(a: Sequence[float], b: Sequence[float]) -> float:
    """Distance within which two points are one."""
    return _SAME_POINT * (float(np.max(np.abs([a, b]))) or 1.0)
