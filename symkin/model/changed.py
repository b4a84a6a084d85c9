"""The same machine at another size, at another place of its base frame, or described at another of
its configurations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from symkin.model.graph import LinkJoint, LinkRod
from symkin.model.joint import Joint
from symkin.model.limb import Limb, RodLimb
from symkin.model.mechanism import Mechanism
from symkin.spatial.pose import Pose

Move = Callable[[str, np.ndarray], np.ndarray]
"""What becomes of a vector of the base frame on a link."""
_STILL = Pose.identity()


def scaled(mechanism: Mechanism, factor: float) -> Mechanism:
    """The same machine with every length times `factor`, without its table of DH and its example.

    >>> import symkin
    >>> round(scaled(symkin.load("delta"), 0.5).characteristic_length, 2)
    221.32
    """
    units = {c.name: c.unit(factor) for c in mechanism.coordinates}
    changed = Changed(lambda _, p: factor * p, lambda _, v: v, lambda p: factor * p, factor)
    return replace(
        changed.mechanism(mechanism),
        couplings=[coupling.in_units(units) for coupling in mechanism.couplings],
        platform_position=changed.times(mechanism.platform_position),
    )


def displaced(
    mechanism: Mechanism, by: Pose, rounding: float = 0.0, inner: Pose = _STILL
) -> Mechanism:
    """The same machine with every point and axis, and the platform, moved by a displacement of the
    base frame, and what its limbs hold in the platform frame by `inner`, without its table of DH
    and its example. Components of directions within `rounding` of 0 and 1, and of points within so
    much of the size of 0, are that.

    >>> import symkin
    >>> up = symkin.Pose.from_euler([0.0, 0.0, 50.0], [0.0, 0.0, 0.0])
    >>> displaced(symkin.load("zhang2009"), up).limbs[0].base
    (0.0, -275.0, 50.0)
    """
    size = mechanism.characteristic_length
    moved = Changed(
        lambda _, p: _rounded(by.apply(p), rounding * size, 0.0),
        lambda _, v: _rounded(by.turn(v), rounding, 1.0),
        inner.apply,
    ).mechanism(mechanism)
    # without a platform there is no frame to move
    without = mechanism.platform_link is None and not mechanism.serial
    return moved if without else with_platform_at(moved, by @ mechanism.reference_pose)


def _rounded(numbers: np.ndarray, rounding: float, most: float) -> np.ndarray:
    """Numbers, with the nearest whole one, up to `most`, in place of those that nearly are it."""
    near = np.clip(np.rint(numbers), -most, most)
    return np.where(np.abs(numbers - near) <= rounding, near, numbers)


def described_at(
    mechanism: Mechanism, links: Mapping[str, Pose], values: Mapping[str, float]
) -> Mechanism:
    """The same machine with the configuration as its reference to which its links are displaced,
    and at which joints of one coordinate have these values; without its table of DH and its
    example.
    """
    moved = Changed(
        lambda link, p: links[link].apply(p), lambda link, v: links[link].turn(v), zeros=values
    ).mechanism(mechanism)
    link, pose = mechanism.platform_link, mechanism.reference_pose
    return with_platform_at(moved, pose if link is None else links[link] @ pose)


def with_platform_at(mechanism: Mechanism, pose: Pose) -> Mechanism:
    """The mechanism with another reference pose of its platform."""
    return replace(
        mechanism,
        platform_position=tuple(np.asarray(pose.position).tolist()),
        platform_quaternion=tuple(np.asarray(pose.quaternion).tolist()),
    )


class Changed:
    """Every part of a description, with its points, directions, those of limbs in the platform
    frame (`inner`), lengths (times `factor`) and values at the reference (`zeros`, by joint)
    changed.
    """

    def __init__(
        self,
        point: Move,
        direction: Move,
        inner: Callable[[np.ndarray], np.ndarray] = lambda p: p,
        factor: float = 1.0,
        zeros: Mapping[str, float] = MappingProxyType({}),
    ) -> None:
        self._point, self._direction, self._inner = point, direction, inner
        self.factor, self.zeros = factor, zeros

    def mechanism(self, given: Mechanism) -> Mechanism:
        """All parts but couplings and the platform's frame."""
        return replace(
            given,
            limbs=[self._limb(limb) for limb in given.limbs],
            link_joints=[
                LinkJoint(self._joint(e.joint, *e.links), e.links) for e in given.link_joints
            ],
            link_rods=[self._rod(rod) for rod in given.link_rods],
            link_points=[replace(p, point=self._at(p.link, p.point)) for p in given.link_points],
            dh=None,
            example=None,
        )

    def times(self, lengths: Sequence[float]) -> tuple[float, ...]:
        return tuple(self.factor * v for v in lengths)

    def _at(self, link: str, point: Sequence[float]) -> tuple[float, ...]:
        return tuple(self._point(link, np.array(point, dtype=float)).tolist())

    def _inside(self, point: Sequence[float]) -> tuple[float, ...]:
        return tuple(self._inner(np.array(point, dtype=float)).tolist())

    def _turned(self, link: str, axis: Sequence[float] | None) -> tuple[float, ...] | None:
        if axis is None:
            return None
        return tuple(self._direction(link, np.array(axis, dtype=float)).tolist())

    def _joint(self, joint: Joint, carrier: str, link: str) -> Joint:
        unit = joint.coordinates[0].unit(self.factor) if joint.freedom == 1 else 1.0
        return replace(
            joint,
            point=self._at(carrier, joint.point),
            axis=self._turned(carrier, joint.axis),
            axis2=self._turned(link, joint.axis2),
            pitch=self.factor * joint.pitch,
            zero=self.zeros.get(joint.name, unit * joint.zero) if joint.freedom == 1 else 0.0,
            limits=None if joint.limits is None else tuple(unit * v for v in joint.limits),
        )

    def _limb(self, limb: Limb | RodLimb) -> Limb | RodLimb:
        if isinstance(limb, RodLimb):
            return replace(
                limb,
                base=self._at(limb.links[0], limb.base),
                platform=self._inside(limb.platform),
                offset=self.factor * limb.offset,
                limits=None if limb.limits is None else self.times(limb.limits),
            )
        links = limb.links_along
        pairs = zip(limb.joints, pairwise(links), strict=True)
        rods = [
            replace(
                rod,
                start=self._at(links[-1], rod.start),
                platform=self._inside(rod.platform),
                length=None if rod.length is None else self.factor * rod.length,
            )
            for rod in limb.rods
        ]
        return replace(limb, joints=[self._joint(j, *ends) for j, ends in pairs], rods=rods)

    def _rod(self, rod: LinkRod) -> LinkRod:
        first, last = rod.links
        return replace(
            rod,
            start=self._at(first, rod.start),
            end=self._at(last, rod.end),
            offset=self.factor * rod.offset,
            length=None if rod.length is None else self.factor * rod.length,
            limits=None if rod.limits is None else self.times(rod.limits),
        )
