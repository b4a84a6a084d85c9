"""The constraints of a graph on its links as free bodies: what each joint, rod and coupling forbids
at the reference, and how many of these rows others imply. No loops are chosen, no motion is
declared, and nothing is taken from symkin but the description.
"""

from __future__ import annotations

import numpy as np

import symkin
from helpers.inside import as_graph, links_of


def redundant_rows(mechanism: symkin.Mechanism) -> int:
    """Rows less their rank, of a mechanism without a declared motion."""
    graph = as_graph(mechanism)
    links = [link for link in links_of(graph) if link != "base"]
    size = graph.characteristic_length
    rows, rates = [], {}
    for entry in graph.link_joints:
        screws = _screws(entry.joint, size)
        between = _between(links, entry.links)
        rows += list(_complement(screws) @ between)
        names = [c.name for c in entry.joint.coordinates]
        # of a slide, and of a cylinder the second, the rate is a length over the size
        rates |= (
            dict(zip(names, np.linalg.pinv(screws.T) @ between, strict=False))
            if len(screws) == len(names)
            else {}
        )
    for rod in graph.link_rods:
        along = np.subtract(rod.end, rod.start)
        wrench = np.concatenate([np.cross(rod.start, along) / size, along]) / np.linalg.norm(along)
        if rod.actuated:
            rates[rod.name] = wrench @ _between(links, rod.links)
        else:
            rows.append(wrench @ _between(links, rod.links))
    kinds = {c.name: c for c in graph.coordinates}
    for coupling in graph.couplings:
        slopes = dict(coupling.terms) if coupling.polynomial is None else {}
        for name in coupling.names if coupling.polynomial is not None else ():
            slopes[name] = float(
                np.polynomial.Polynomial(coupling.polynomial).deriv()(kinds[name].reference[0])
            )
        unit = {
            name: size if kinds[name].kind == "length" else 1.0
            for name in (coupling.joint, *slopes)
        }
        row = unit[coupling.joint] * rates[coupling.joint] - sum(
            f * unit[n] * rates[n] for n, f in slopes.items()
        )
        rows.append(row / np.linalg.norm(row))
    if not rows:
        return 0
    values = np.linalg.svd(np.array(rows), compute_uv=False)
    return len(rows) - int(np.sum(values > 1e-8 * values[0]))


def _between(links: list[str], ends: tuple[str, str]) -> np.ndarray:
    """The twist of a second link against a first, of the twists of all links."""
    found = np.zeros((6, 6 * len(links)))
    for sign, link in zip((-1.0, 1.0), ends, strict=True):
        if link in links:
            k = 6 * links.index(link)
            found[:, k : k + 6] = sign * np.eye(6)
    return found


def _complement(screws: np.ndarray) -> np.ndarray:
    """Rows that vanish on some twists."""
    if not len(screws):
        return np.eye(6)
    _, values, rows = np.linalg.svd(screws)
    return rows[int(np.sum(values > 1e-12)) :]


def _screws(joint: symkin.Joint, size: float) -> np.ndarray:
    """Twists (angular velocity; velocity at the origin over the size) of a joint at the
    reference.
    """

    def turn(axis: object) -> np.ndarray:
        return np.concatenate([axis, np.cross(joint.point, axis) / size])

    def slide(axis: object) -> np.ndarray:
        return np.concatenate([np.zeros(3), axis])

    match joint.type:
        case "weld":
            return np.zeros((0, 6))
        case "S":
            return np.array([turn(axis) for axis in np.eye(3)])
        case "U":
            return np.array([turn(joint.axis), turn(joint.axis2)])
        case "C":
            return np.array([turn(joint.axis), slide(joint.axis)])
        case "P":
            return slide(joint.axis)[None]
        case _:
            return (turn(joint.axis) + joint.pitch / (2 * np.pi * size) * slide(joint.axis))[None]
