"""Scale a mechanism: the same machine at another size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symkin.model.graph import Coupling, LinkRod
from symkin.model.joint import Joint
from symkin.model.limb import Limb, RodLimb
from symkin.model.mechanism import Mechanism


def scaled(mechanism: Mechanism, factor: float) -> Mechanism:
    """The same machine with every length times `factor`, without its table of DH and its example.

    >>> import symkin
    >>> round(scaled(symkin.load("delta"), 0.5).characteristic_length, 2)
    221.32
    """
    is_length = {c.name: c.kind == "length" for c in mechanism.coordinates}
    return replace(
        mechanism,
        limbs=[_limb(item, factor) for item in mechanism.limbs],
        link_joints=[
            replace(item, joint=_joint(item.joint, factor)) for item in mechanism.link_joints
        ],
        link_rods=[_rod(item, factor) for item in mechanism.link_rods],
        couplings=[_coupling(item, factor, is_length) for item in mechanism.couplings],
        link_points=[
            replace(item, point=_times(factor, item.point)) for item in mechanism.link_points
        ],
        platform_position=_times(factor, mechanism.platform_position),
        dh=None,
        example=None,
    )


def _times(factor: float, numbers: Sequence[float]) -> tuple[float, ...]:
    return tuple(factor * v for v in numbers)


def _joint(joint: Joint, factor: float) -> Joint:
    moved = replace(joint, point=_times(factor, joint.point), pitch=factor * joint.pitch)
    if joint.type != "P":
        return moved
    limits = None if joint.limits is None else _times(factor, joint.limits)
    return replace(moved, zero=factor * joint.zero, limits=limits)


def _limb(limb: Limb | RodLimb, factor: float) -> Limb | RodLimb:
    if isinstance(limb, RodLimb):
        return replace(
            limb,
            base=_times(factor, limb.base),
            platform=_times(factor, limb.platform),
            offset=factor * limb.offset,
            limits=None if limb.limits is None else _times(factor, limb.limits),
        )
    rods = [
        replace(
            rod,
            start=_times(factor, rod.start),
            platform=_times(factor, rod.platform),
            length=None if rod.length is None else factor * rod.length,
        )
        for rod in limb.rods
    ]
    return replace(limb, joints=[_joint(joint, factor) for joint in limb.joints], rods=rods)


def _rod(rod: LinkRod, factor: float) -> LinkRod:
    return replace(
        rod,
        start=_times(factor, rod.start),
        end=_times(factor, rod.end),
        offset=factor * rod.offset,
        length=None if rod.length is None else factor * rod.length,
        limits=None if rod.limits is None else _times(factor, rod.limits),
    )


def _coupling(coupling: Coupling, factor: float, is_length: dict[str, bool]) -> Coupling:
    own = int(is_length[coupling.joint])
    if coupling.polynomial is not None:
        of = int(is_length[str(coupling.of)])
        powers = [factor ** (own - k * of) for k in range(len(coupling.polynomial))]
        return replace(
            coupling,
            polynomial=[c * p for c, p in zip(coupling.polynomial, powers, strict=True)],
        )
    terms = [(name, f * factor ** (own - int(is_length[name]))) for name, f in coupling.terms]
    return replace(coupling, of=terms, offset=coupling.offset * factor**own)
