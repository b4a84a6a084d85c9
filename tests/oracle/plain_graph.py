"""Configurations of a mechanism given as a graph of links and joints, by random starts in maximal
coordinates, NumPy only.

An oracle that shares nothing with symkin: it reads a mechanism file by itself, gives every link a
position p and a unit quaternion Q, every joint its coordinates v, and writes each joint between
links A and B as (frames of links: the base frame at the reference)

    A(from) + sum of slides R_A a - B(to) = 0        3 rows
    vector part of Q_A Q(turns) (Q_B Q_home)^-1 = 0  3 rows, none for S

each rod as one distance, each coupling as one row. Lengths are over the size (largest distance
between joint points), angles in radians. Configurations are told apart by all joint coordinates,
the platform's pose, the centres of spherical joints and rods' ends: the spin of a rod is none.

Run: python tests/oracle/plain_graph.py FILE.toml [NAME=VALUE ...] [--starts N] [--seed N]
"""

from __future__ import annotations

import argparse
import math
import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from oracle.plain_graph_file import Array, Coupling, GraphFile, Joint, Reader, Rod, number

CLOSED = 1e-10
"""Largest row of a closed configuration (share of the size, rad)."""
DISTINCT = 1e-5
"""Least difference of a feature between two configurations; closed ones agree to about 1e-9."""
FREE = 1e-8
"""A singular value below this share of the largest is none."""
BATCH = 250
"""Starts solved at once: their Jacobians stay in some ten megabytes."""
ROUNDING = 1e-13
"""Least damping, above the rounding of normal equations with entries near 1: idle motions leave
them singular.
"""
REACH = 1.5
"""Slides and free links start within this many sizes of the reference."""


# --- quaternions (n, 4), scalar first -------------------------------------------------------------


def product(a: Array, b: Array) -> Array:
    """Quaternion products, row by row."""
    scalar = a[..., :1] * b[..., :1] - np.sum(a[..., 1:] * b[..., 1:], axis=-1, keepdims=True)
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + _cross(a[..., 1:], b[..., 1:])
    return np.concatenate([scalar, vector], axis=-1)


def turn(axis: Array, angles: Array) -> Array:
    """Unit quaternions (n, 4) of turns by angles (n,) about a unit axis."""
    return np.concatenate([np.cos(angles / 2)[:, None], np.sin(angles / 2)[:, None] * axis], axis=1)


def rotate(q: Array, v: Array) -> Array:
    """Vectors v (3,) or (n, 3) rotated by unit quaternions (n, 4)."""
    u = _cross(q[:, 1:], v) * 2
    return np.asarray(v + q[:, :1] * u + _cross(q[:, 1:], u))


def _cross_matrix(v: Array) -> Array:
    m = np.zeros((*v.shape[:-1], 3, 3))
    m[..., 0, 1], m[..., 0, 2], m[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    return m - np.swapaxes(m, -1, -2)


def _cross(a: Array, b: Array) -> Array:
    """a x b; NumPy's own takes many times as long for few vectors."""
    return np.asarray((_cross_matrix(a) @ b[..., None])[..., 0])


# --- the closure ----------------------------------------------------------------------------------


class Graph(GraphFile):
    """A mechanism read from a file; a configuration is a row of 7 numbers a moving link (p, Q),
    then the coordinates.
    """

    @property
    def loops(self) -> int:
        """Independent loops: joints and rods beyond one a moving link."""
        return len(self.joints) + len(self.rods) - len(self.names)

    @property
    def freedom(self) -> int:
        """Tangent columns: 6 a link, one a coordinate."""
        return 6 * len(self.names) + len(self.coordinates)

    def place(self, name: str) -> int:
        """Place of a named coordinate."""
        return [c.name for c in self.coordinates].index(name)

    def reference(self) -> Array:
        """The configuration of the file."""
        links = np.concatenate(
            [self.centres, np.tile([1.0, 0.0, 0.0, 0.0], (len(self.names), 1))], axis=1
        )
        return np.concatenate([links.ravel(), [c.zero for c in self.coordinates]])

    def link(self, x: Array, i: int) -> tuple[Array, Array, Array]:
        """Positions, quaternions of link i, and the point of the reference that its position
        carries.
        """
        if i < 0:
            return np.zeros((len(x), 3)), np.tile([1.0, 0.0, 0.0, 0.0], (len(x), 1)), np.zeros(3)
        return x[:, 7 * i : 7 * i + 3], x[:, 7 * i + 3 : 7 * i + 7], self.centres[i]

    def values(self, x: Array) -> Array:
        """Joint coordinates (n, m)."""
        return np.asarray(x[:, 7 * len(self.names) :])

    def point(self, x: Array, i: int, there: Array) -> Array:
        """A point of link i where it is now (n, 3)."""
        p, q, centre = self.link(x, i)
        return np.asarray(p + rotate(q, there - centre))

    def move(self, x: Array, step: Array) -> Array:
        """Configurations moved by tangent steps: positions, turns in the base frame,
        coordinates.
        """
        x, count = x.copy(), len(self.names)
        for i in range(count):
            x[:, 7 * i : 7 * i + 3] += step[:, 6 * i : 6 * i + 3]
            w = step[:, 6 * i + 3 : 6 * i + 6]
            q = product(
                np.concatenate([np.ones((len(x), 1)), w / 2], axis=1), x[:, 7 * i + 3 : 7 * i + 7]
            )
            x[:, 7 * i + 3 : 7 * i + 7] = q / np.linalg.norm(q, axis=1, keepdims=True)
        x[:, 7 * count :] += step[:, 6 * count :]
        return x

    def closure(self, x: Array) -> tuple[Array, Array]:
        """Rows (n, rows) and their derivatives by the tangent (n, rows, freedom)."""
        parts = [part for joint in self.joints for part in self._joint(x, joint)]
        parts += [self._rod(x, rod) for rod in self.rods] + [
            self.coupling_row(x, c) for c in self.couplings
        ]
        return np.concatenate([r for r, _ in parts], axis=1), np.concatenate(
            [d for _, d in parts], axis=1
        )

    def point_derivative(self, x: Array, i: int, there: Array) -> Array:
        """Derivative (n, 3, freedom) of a point of link i."""
        d = np.zeros((len(x), 3, self.freedom))
        if i >= 0:
            d[:, :, 6 * i : 6 * i + 3] = np.eye(3)
            d[:, :, 6 * i + 3 : 6 * i + 6] = -_cross_matrix(
                self.point(x, i, there) - self.link(x, i)[0]
            )
        return d

    def _joint(self, x: Array, joint: Joint) -> list[tuple[Array, Array]]:
        (a, b), v, first = joint.links, self.values(x), 6 * len(self.names)
        q_a, q_b = self.link(x, a)[1], product(self.link(x, b)[1], joint.home[None])
        parts = []
        if joint.holds[0]:
            gap = self.point(x, a, joint.ends[0]) - self.point(x, b, joint.ends[1])
            d = self.point_derivative(x, a, joint.ends[0]) - self.point_derivative(
                x, b, joint.ends[1]
            )
            for axis, k, factor in joint.slides:
                there = factor * rotate(q_a, axis)
                amount = (v[:, k] - self.coordinates[k].zero)[:, None]
                gap, d[:, :, first + k] = gap + amount * there, d[:, :, first + k] + there
                if a >= 0:
                    d[:, :, 6 * a + 3 : 6 * a + 6] -= _cross_matrix(amount * there)
            parts.append((gap, d))
        if joint.holds[1]:
            carried, axes = q_a, []
            for axis, k, factor in joint.turns:
                axes.append((k, factor * rotate(carried, axis)))
                carried = product(
                    carried, turn(axis, factor * (v[:, k] - self.coordinates[k].zero))
                )
            e = product(carried, q_b * np.array([1.0, -1.0, -1.0, -1.0]))
            by_a = (e[:, :1, None] * np.eye(3) - _cross_matrix(e[:, 1:])) / 2
            d = np.zeros((len(x), 3, self.freedom))
            if a >= 0:
                d[:, :, 6 * a + 3 : 6 * a + 6] = by_a
            if b >= 0:
                d[:, :, 6 * b + 3 : 6 * b + 6] = -np.swapaxes(by_a, 1, 2)
            for k, axis_now in axes:
                d[:, :, first + k] += np.einsum("nij,nj->ni", by_a, axis_now)
            parts.append((e[:, 1:], d))
        return parts

    def _rod(self, x: Array, rod: Rod) -> tuple[Array, Array]:
        gap = self.point(x, rod.links[0], rod.ends[0]) - self.point(x, rod.links[1], rod.ends[1])
        far = np.linalg.norm(gap, axis=1)
        d = self.point_derivative(x, rod.links[0], rod.ends[0]) - self.point_derivative(
            x, rod.links[1], rod.ends[1]
        )
        by = np.einsum("ni,nif->nf", gap / np.maximum(far, 1e-300)[:, None], d)
        if rod.coordinate >= 0:
            by[:, 6 * len(self.names) + rod.coordinate] -= 1
            far = far - self.values(x)[:, rod.coordinate]
        return (far - rod.length)[:, None], by[:, None, :]

    def coupling_row(self, x: Array, coupling: Coupling) -> tuple[Array, Array]:
        """A coupling's row, linear in its own joint's coordinate with slope 1, and its
        derivative.
        """
        first, v, own = 6 * len(self.names), self.values(x), self.coordinates[coupling.joint].unit
        r, d = v[:, coupling.joint] / own - coupling.offset, np.zeros((len(x), 1, self.freedom))
        d[:, 0, first + coupling.joint] = 1
        for k, coefficients in coupling.terms:
            u, polynomial = (
                v[:, k] / self.coordinates[k].unit,
                np.polynomial.Polynomial([0.0, *coefficients]),
            )
            r = r - polynomial(u)
            d[:, 0, first + k] -= polynomial.deriv()(u) * own / self.coordinates[k].unit
        return (r * own)[:, None], d

    def observed(self, x: Array) -> tuple[Array, Array]:
        """Numbers (n, f) by which configurations are told apart, and their derivatives by the
        tangent (n, f, freedom).
        """
        kept = [k for k in range(len(self.coordinates)) if k not in self.idle]
        v, angle = (
            self.values(x)[:, kept],
            np.array([self.coordinates[k].angle for k in kept], bool),
        )
        parts = [np.where(angle, np.cos(v), v), np.where(angle, np.sin(v), 0.0)]
        derivatives = [
            np.tile(np.eye(self.freedom)[[6 * len(self.names) + k for k in kept]], (len(x), 1, 1))
        ]
        for i, there in self.points:
            parts.append(self.point(x, i, there))
            derivatives.append(self.point_derivative(x, i, there))
        return np.concatenate(parts, axis=1), np.concatenate(derivatives, axis=1)


def read(path: Path, given: Sequence[str] = ()) -> Graph:
    """Read a mechanism file; pose coordinates are there where `given` names one."""
    return Graph(**vars(Reader(tomllib.loads(path.read_text()), given).graph()))


# --- solving --------------------------------------------------------------------------------------


def solve(g: Graph, x: Array, columns: Array, steps: int = 120) -> Array:
    """Levenberg-Marquardt of all rows in some tangent columns, from all configurations (n, numbers)
    at once.
    """
    x, damping, active = x.copy(), np.full(len(x), 1e-2), np.arange(len(x))
    r, j = g.closure(x)
    for _ in range(steps):
        if not len(active) or not len(columns):
            break
        a = j[:, :, columns]
        normal, gradient = np.swapaxes(a, 1, 2) @ a, np.einsum("nri,nr->ni", a, r)
        diagonal = np.arange(len(columns))
        normal[:, diagonal, diagonal] += (damping * np.linalg.norm(r, axis=1))[:, None] + ROUNDING
        step = np.zeros((len(active), g.freedom))
        step[:, columns] = -np.linalg.solve(normal, gradient[:, :, None])[:, :, 0]
        step *= np.minimum(1.0, 2.0 / np.maximum(np.linalg.norm(step, axis=1), 1e-300))[:, None]
        trial = g.move(x[active], step)
        r_trial, j_trial = g.closure(trial)
        better = np.sum(r_trial**2, axis=1) < np.sum(r**2, axis=1)
        x[active[better]] = trial[better]
        r, j = np.where(better[:, None], r_trial, r), np.where(better[:, None, None], j_trial, j)
        damping = np.clip(np.where(better, damping / 4, damping * 4), 1e-12, 1e8)
        going = (np.max(np.abs(r), axis=1) > 1e-14) & (damping < 1e7)
        active, damping, r, j = active[going], damping[going], r[going], j[going]
    return x


def random_starts(
    g: Graph, count: int, fixed: Mapping[int, float], rng: np.random.Generator
) -> Array:
    """Configurations with random coordinates, links carried along a random spanning tree of joints,
    closed nowhere else.
    """
    x, first = np.tile(g.reference(), (count, 1)), 7 * len(g.names)
    for k, c in enumerate(g.coordinates):
        spread = math.pi if c.angle else REACH
        x[:, first + k] = fixed.get(k, c.zero + rng.uniform(-spread, spread, count))
    for coupling in g.couplings:
        if coupling.joint not in fixed:
            x[:, first + coupling.joint] -= g.coupling_row(x, coupling)[0][:, 0]
    placed = {-1}
    order = [g.joints[k] for k in rng.permutation(len(g.joints))]
    while len(placed) <= len(g.names):
        joint = next((j for j in order if len(placed & set(j.links)) == 1 and j.holds[0]), None)
        if joint is None:
            i = next(i for i in rng.permutation(len(g.names)) if i not in placed)
            x[:, 7 * i : 7 * i + 3] += rng.uniform(-REACH, REACH, (count, 3))
            x[:, 7 * i + 3 : 7 * i + 7] = _random_turns(count, rng)
            placed.add(int(i))
            continue
        _carry(g, x, joint, joint.links[0] in placed, rng)
        placed |= set(joint.links)
    return x


def _random_turns(count: int, rng: np.random.Generator) -> Array:
    q = rng.normal(size=(count, 4))
    return np.asarray(q / np.linalg.norm(q, axis=1, keepdims=True))


def _carry(g: Graph, x: Array, joint: Joint, forward: bool, rng: np.random.Generator) -> None:
    """Place the other link of a joint by its coordinates."""
    v, back = g.values(x), np.array([1.0, -1.0, -1.0, -1.0])
    q = np.tile([1.0, 0.0, 0.0, 0.0], (len(x), 1)) if joint.holds[1] else _random_turns(len(x), rng)
    for axis, k, factor in joint.turns:
        q = product(q, turn(axis, factor * (v[:, k] - g.coordinates[k].zero)))
    a, b = joint.links
    here = a if forward else b
    q_here, there = g.link(x, here)[1], b if forward else a
    q_there = product(q_here, q if forward else q * back)
    q_a = q_here if forward else q_there
    meet = g.point(x, here, joint.ends[0 if forward else 1])
    for axis, k, factor in joint.slides:
        meet += (
            (1 if forward else -1)
            * (factor * (v[:, k] - g.coordinates[k].zero))[:, None]
            * rotate(q_a, axis)
        )
    x[:, 7 * there + 3 : 7 * there + 7] = q_there
    x[:, 7 * there : 7 * there + 3] = meet + rotate(
        q_there, g.centres[there] - joint.ends[1 if forward else 0]
    )


# --- configurations -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Found:
    """Distinct configurations (k, numbers), how often each was met, whether each is isolated, and
    its clearance: the least singular value that counts, over the largest.
    """

    x: Array
    hits: Array
    isolated: Array
    clearance: Array
    starts: int


def configurations(
    g: Graph, given: Mapping[str, float], starts: int, seed: int = 0, most: int = 1000
) -> Found:
    """Distinct configurations with coordinates given by name in file units, from random starts."""
    rng, fixed = (
        np.random.default_rng(seed),
        {g.place(n): value * g.coordinates[g.place(n)].unit for n, value in given.items()},
    )
    columns = np.setdiff1d(np.arange(g.freedom), [6 * len(g.names) + k for k in fixed])
    x = g.reference()[None]
    kept, features, hits = x[:0], g.observed(x)[0][:0], np.zeros(0, int)
    for begin in range(0, starts, BATCH):
        ends = solve(g, random_starts(g, min(BATCH, starts - begin), fixed, rng), columns)
        ends = ends[closed(g, ends)]
        for end, f in zip(ends, g.observed(ends)[0], strict=True):
            near = np.flatnonzero(np.max(np.abs(features - f), axis=1) < DISTINCT)
            if len(near):
                hits[near[0]] += 1
            elif len(kept) < most:
                kept, features, hits = (
                    np.vstack([kept, end]),
                    np.vstack([features, f]),
                    np.append(hits, 1),
                )
    ranks = [freedom(g, end, columns) for end in kept]
    isolated = np.array([r[1] == 0 for r in ranks], bool)
    return Found(kept, hits, isolated, np.array([r[2] for r in ranks]), starts)


def closed(g: Graph, x: Array) -> Array:
    """Which configurations (n,) close every row, with rods of positive length and a tilt of 0 to
    half a turn.
    """
    v = g.values(x)
    good = np.max(np.abs(g.closure(x)[0]), axis=1, initial=0.0) < CLOSED
    for rod in g.rods:
        if rod.coordinate >= 0:
            good &= rod.length + v[:, rod.coordinate] > 0
    for k in (k for k, c in enumerate(g.coordinates) if c.name == "tilt"):
        good &= np.sin(v[:, k]) > -DISTINCT
    return np.asarray(good)


def freedom(g: Graph, x: Array, columns: Array | None = None) -> tuple[int, int, float]:
    """Rank of the rows at a configuration, its freedoms without idle ones, and the least singular
    value that counts, over the largest: an idle motion moves no observed number.
    """
    columns = np.arange(g.freedom) if columns is None else columns
    j, seen = g.closure(x[None])[1][0][:, columns], g.observed(x[None])[1][0][:, columns]
    _, s, right = np.linalg.svd(j, full_matrices=True)
    rank = int(np.sum(s > FREE * s[0])) if len(s) else 0
    moving = (
        np.linalg.svd(seen @ right[rank:].T, compute_uv=False) if rank < len(right) else np.zeros(0)
    )
    return rank, int(np.sum(moving > 1e-6)), float(s[rank - 1] / s[0]) if rank else 1.0


def generic(g: Graph, count: int = 40, spread: float = 0.1, seed: int = 0) -> Array:
    """Closed configurations near the reference, from random steps off it."""
    rng = np.random.default_rng(seed)
    begin = g.move(np.tile(g.reference(), (count, 1)), spread * rng.normal(size=(count, g.freedom)))
    ends = solve(g, begin, np.arange(g.freedom))
    return np.asarray(ends[closed(g, ends)])


@dataclass(frozen=True)
class Structure:
    """Numbers of a graph at generic closed configurations: the base counts as a link, a rod as a
    joint of a loop.
    """

    links: int
    joints: int
    rods: int
    loops: int
    rows: int
    rank: int
    redundant: int
    mobility: int
    idle: int


def structure(g: Graph) -> Structure:
    """Links, joints, loops, rank, mobility: the largest rank found near the reference, six minimal
    rows a held joint.
    """
    found = [freedom(g, x) for x in generic(g)]
    rank, mobility, _ = max(found) if found else freedom(g, g.reference())
    rows = g.closure(g.reference()[None])[0].shape[1]
    idle = g.freedom - rank - mobility
    return Structure(
        len(g.names) + 1,
        len(g.joints),
        len(g.rods),
        g.loops,
        rows,
        rank,
        rows - rank,
        mobility,
        idle,
    )


def main() -> None:
    """Print a file's structure, and its configurations for given values."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("given", nargs="*", help="NAME=VALUE in the file's units")
    parser.add_argument("--starts", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--list", action="store_true", help="print the coordinates of each configuration"
    )
    options = parser.parse_args()
    given = {n: number(v) for n, v in (item.split("=") for item in options.given)}
    g = read(options.file)
    print(f"{options.file.stem}: {structure(g)}")
    opening = float(np.max(np.abs(g.closure(g.reference()[None])[0])))
    actuated = ", ".join(c.name for c in g.coordinates if c.actuated)
    print(f"open by {opening:.1e} of the size at the reference; actuated: {actuated}")
    if not given and structure(g).mobility:
        return
    g = read(options.file, list(given))
    found = configurations(g, given, options.starts, options.seed)
    isolated, least = int(np.sum(found.isolated)), min(found.clearance, default=1.0)
    print(
        f"{len(found.x)} configurations ({isolated} isolated) from {found.starts} starts, hits "
        f"{found.hits.tolist()}"
    )
    print(f"least clearance {least:.1e}")
    for v in g.values(found.x) if options.list else ():
        print(
            "  "
            + ", ".join(
                f"{c.name} {value / c.unit:.6g}" for c, value in zip(g.coordinates, v, strict=True)
            )
        )


if __name__ == "__main__":
    main()
