"""When two graphs of links are one mechanism: the same links, and joints, rods and couplings with
the same names, types and screws; and the same values of the same names mean the same poses.
"""

from __future__ import annotations

import numpy as np

import symkin
from helpers.inside import links_of
from oracle.product_of_exponentials import between_links, random_values

DIGITS = 1e-12
"""Of the size: the rounding of sums and turns of numbers that are written with all their digits."""


def assert_same(
    expected: symkin.Mechanism, found: symkin.Mechanism, digits: float = DIGITS
) -> None:
    """Both are graphs in metres and radians."""
    size = max(
        expected.characteristic_length,
        *(float(np.linalg.norm(j.point)) for j in expected.all_joints),
        0.0,
    )
    assert set(links_of(found)) == set(links_of(expected))
    assert [c.name for c in found.actuated] == [c.name for c in expected.actuated]
    joints, others = ({e.joint.name: e for e in m.link_joints} for m in (expected, found))
    assert list(others) == list(joints)
    for name, entry in joints.items():
        _assert_joint(entry, others[name], size, digits)
    _assert_same_meaning(expected, found, size, digits)
    rods, more = ({rod.name: rod for rod in m.link_rods} for m in (expected, found))
    assert list(more) == list(rods)
    for name, rod in rods.items():
        _assert_rod(rod, more[name], size, digits)
    assert found.platform_link == expected.platform_link
    for key in ("platform_position", "platform_quaternion"):
        np.testing.assert_allclose(
            getattr(found, key),
            getattr(expected, key),
            rtol=0,
            atol=digits * max(size, 1.0),
            err_msg=key,
        )
    points, others = ({p.name: p for p in m.link_points} for m in (expected, found))
    assert {name: p.link for name, p in others.items()} == {
        name: p.link for name, p in points.items()
    }
    for name, point in points.items():
        np.testing.assert_allclose(
            others[name].point, point.point, rtol=0, atol=digits * max(size, 1.0), err_msg=name
        )
    couplings, told = ({c.joint: c for c in m.couplings} for m in (expected, found))
    assert set(told) == set(couplings)
    for name, coupling in couplings.items():
        assert set(told[name].names) == set(coupling.names), name
        for seed in range(4):
            values = dict(
                zip(
                    coupling.names,
                    np.random.default_rng(seed).uniform(-2, 2, len(coupling.names)),
                    strict=True,
                )
            )
            assert _follows(told[name], values) == _near(
                _follows(coupling, values), 16.0, digits
            ), name


def _assert_joint(
    entry: symkin.LinkJoint, other: symkin.LinkJoint, size: float, digits: float
) -> None:
    joint, found, name = entry.joint, other.joint, entry.joint.name
    assert found.type == joint.type, name
    assert found.actuated == joint.actuated, name
    assert (found.limits is None) == (joint.limits is None), name
    assert tuple(other.links) == tuple(entry.links), name
    np.testing.assert_allclose(
        _lines(found), _lines(joint), rtol=0, atol=digits * max(size, 1.0), err_msg=name
    )
    numbers, others = ([j.zero, j.pitch, *(j.limits or ())] for j in (joint, found))
    np.testing.assert_allclose(
        others, numbers, rtol=digits, atol=digits * max(size, 1.0), err_msg=name
    )


def _assert_same_meaning(
    expected: symkin.Mechanism, found: symkin.Mechanism, size: float, digits: float
) -> None:
    """Values of coordinates by name place the links of each joint alike, by an account of their
    screws that is none of symkin's.
    """
    values = random_values(expected, 0)
    assert set(values) == {c.name for c in found.coordinates}
    placed, others = (between_links(m, values) for m in (expected, found))
    for name, (link, pose) in placed.items():
        assert others[name][0] == link, name
        np.testing.assert_allclose(
            others[name][1], pose, rtol=0, atol=10 * digits * max(size, 1.0), err_msg=name
        )


def _lines(joint: symkin.Joint) -> np.ndarray:
    """The joint's axes as lines (direction, moment) as seen from its first link; the point of a
    ball; the direction of a slide.
    """
    if joint.type == "weld":
        return np.zeros(0)
    if joint.type == "S":
        return np.array(joint.point)
    axes = [np.array(a) for a in (joint.axis, joint.axis2) if a is not None]
    if joint.type == "P":
        return axes[0]
    return np.concatenate([part for a in axes for part in (a, np.cross(joint.point, a))])


def _assert_rod(rod: symkin.LinkRod, found: symkin.LinkRod, size: float, digits: float) -> None:
    assert found.links == rod.links, rod.name
    assert found.actuated == rod.actuated, rod.name
    assert (found.limits is None) == (rod.limits is None), rod.name
    for key in ("start", "end", "offset", "limits"):
        own, other = getattr(rod, key), getattr(found, key)
        if own is not None:
            np.testing.assert_allclose(
                other, own, rtol=0, atol=digits * max(size, 1.0), err_msg=f"{rod.name}: {key}"
            )
    lengths = [r.length if r.length is not None else r.reference_length for r in (rod, found)]
    assert lengths[1] == _near(lengths[0], size, digits), rod.name


def _follows(coupling: symkin.Coupling, values: dict[str, float]) -> float:
    if coupling.polynomial is not None:
        return sum(c * values[coupling.names[0]] ** k for k, c in enumerate(coupling.polynomial))
    return coupling.offset + sum(factor * values[name] for name, factor in coupling.terms)


def _near(value: float, size: float, digits: float) -> object:
    import pytest

    return pytest.approx(value, rel=digits, abs=digits * max(size, 1.0))
