"""Whether OK of generated C means that all loops close: machines of all kinds, poses on and off
what they can take.

    python codegen/bench/closes.py [--random 30] [--seed 0] [--poses 60] [--only NAME]
        [--kind map|arm|platform] [--no-named]

What C answers is put into the closure of tests/oracle/plain_closure.py and plain_graph.py, where
every joint keeps its coordinates; passive joints are looked for from many starts. Each answer is
asked for once more, from itself: standing still has to be OK. A folder's own test is run when it is
written. The last line has the numbers of machines, calls, OKs, OKs that do not close, own tests
that fail and refusals of standing still. Exit status 1 where one of the last three is not zero.
"""

from __future__ import annotations

import argparse
import ctypes
import signal
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[2] / "tests"))

import symkin
from asked import Machine, asked, built
from campaigns.random_files import random_file, to_toml
from campaigns.random_graphs import Drawing
from oracle import plain_graph
from oracle.plain_closure import PlainMechanism, matrix_quaternion
from oracle.plain_search import closed_configurations, random_configurations, solve
from subjects import ARMS, MAPS, PLACE, PLATFORMS, machine_of
from symkin.errors import InputError, SymkinError
from symkin.machine.limbs import with_limbs
from symkin.model.mechanism import Mechanism
from symkin.model.writer import mechanism_to_toml

LOOPS = {
    "four_bar": (("crank", "crank_pin"), ("follower", "follower_pin")),
    "bennett": (("input", "crank_pin"), ("output", "rocker_pin")),
    "sarrus": (("foot_x", "elbow_x", "head_x"), ("foot_y", "elbow_y", "head_y")),
    "goldberg": (("input", "q_pin"), ("output", "p4_pin", "w_pin")),
}
"""Loops of a graph that are written as two limbs: which joints each has, from the base on."""
CLOSES = {"float": 4e-5, "double": 4e-6}
"""Largest closure error of an OK, over the size: 1e-6, or 64 roundings, of each row, a few of which
add up in rows written otherwise.
"""
OWN_TEST = "own test fails"
"""What a refusal says of code that was not written because its test fails."""
SECONDS = 60
"""Processor time of this process after which a machine is left out in a type."""
STARTS = 24


@dataclass
class Tally:
    """What came of one machine's code in one type: calls, OKs, OKs that do not close, the worst of
    these, answers that are refused when they are asked for from themselves.
    """

    name: str
    kind: str
    real: str
    calls: int = 0
    ok: int = 0
    open: int = 0
    worst: float = 0.0
    moved: int = 0
    on_set: int = 0
    on_set_ok: int = 0
    examples: list[str] = field(default_factory=list)

    def line(self) -> str:
        return (
            f"{self.name:28} {self.kind:9} {self.real:6} calls {self.calls:5} OK {self.ok:5} open "
            f"{self.open:4} worst {self.worst:8.1e} "
            f"still refused {self.moved:3} feasible taken {self.on_set_ok}/{self.on_set}"
        )


# --- platforms and arms by limbs ------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Limbs:
    """The plain closure of a mechanism of limbs, and configurations of it."""

    plain: PlainMechanism
    rng: np.random.Generator

    def poses(self, x: np.ndarray) -> np.ndarray:
        position, rotation = self.plain.pose(x)
        return np.column_stack([position, np.array([matrix_quaternion(r) for r in rotation])])

    def joints(self, x: np.ndarray) -> np.ndarray:
        return np.column_stack([x[:, self.plain.slices[i]] for i in self.plain.places("actuated")])

    def moved(self, poses: np.ndarray) -> np.ndarray:
        """Poses aside, by 1e-3 to a third of the size and as many radians."""
        far = 10.0 ** self.rng.uniform(-3.0, -0.5, (len(poses), 1))
        step = self.rng.normal(size=(len(poses), 6))
        half = 0.5 * far * step[:, 3:]
        turned = np.array(
            [_product(np.array([1.0, *h]), q) for h, q in zip(half, poses[:, 3:], strict=True)]
        )
        turned /= np.linalg.norm(turned, axis=1, keepdims=True)
        return np.column_stack([poses[:, :3] + self.plain.size * far * step[:, :3], turned])

    def gaps(self, begin: np.ndarray, poses: np.ndarray, joints: np.ndarray) -> np.ndarray:
        """How far from closing (n,), over the size, configurations with poses and joint values are
        at best.
        """
        m, found = self.plain, []
        passive = m.places("passive")
        for x, pose, values in zip(begin, poses, joints, strict=True):
            start = m.with_pose(x[None], pose[:3], pose[3:] / np.linalg.norm(pose[3:]))
            for i, value in zip(m.places("actuated"), values, strict=True):
                start[:, m.slices[i]] = value
            gap = float(m.residual(solve(m, start, m.tangent(passive), 40))[0])
            if gap > 1e-6 and passive:
                many = random_configurations(m, np.tile(start, (STARTS, 1)), passive, self.rng)
                gap = min(gap, float(m.residual(solve(m, many, m.tangent(passive), 60)).min()))
            found.append(gap)
        return np.array(found)


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    w, v = a[0] * b[0] - a[1:] @ b[1:], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])
    return np.array([w, *v])


def projected(m: PlainMechanism, poses: np.ndarray) -> np.ndarray:
    """Poses with the numbers that the declared motion has."""
    found = []
    for pose in poses:
        x = m.with_pose(m.reference[None], pose[:3], pose[3:])
        position, rotation = m.pose(x)
        found.append([*position[0], *matrix_quaternion(rotation[0])])
    return np.array(found)


def _ask(
    tally: Tally,
    function: ctypes._CFuncPtr,
    what: str,
    given: Sequence[np.ndarray],
    width: int,
    gaps: Callable[[np.ndarray, np.ndarray], np.ndarray],
    on_set: int = 0,
) -> None:
    """Ask for goals, from guesses where the problem has any, and then for each answer from itself.
    `gaps` tell of answers, with the places of their goals, how far from closing they are; the first
    `on_set` goals are such that the machine can take.
    """
    order = "iiosn" if len(given) == 2 else "ios"
    found, status, *_ = asked(function, tally.real, given, [width], order)
    at = np.flatnonzero(status == 0)
    tally.calls, tally.ok = tally.calls + len(status), tally.ok + len(at)
    tally.on_set, tally.on_set_ok = (
        tally.on_set + on_set,
        tally.on_set_ok + int(np.sum(at < on_set)),
    )
    if len(given) == 2 and len(at):
        again = asked(function, tally.real, [given[0][at], found[at]], [width], order)[1]
        tally.moved += int(np.sum(again != 0))
        tally.examples += [
            f"{what}: standing still refused ({again[k]}): {given[0][at[k]].tolist()} from "
            f"{found[at[k]].tolist()}"
            for k in np.flatnonzero(again)[:2]
        ]
    off = gaps(at, found[at])
    tally.worst = max(tally.worst, float(off.max(initial=0.0)))
    bad = np.flatnonzero(off > CLOSES[tally.real])
    tally.open += len(bad)
    tally.examples += [
        f"{what}: {given[0][at[k]].tolist()} gives {found[at[k]].tolist()} open by {off[k]:.2g}"
        for k in bad[:2]
    ]


def of_limbs(
    machine: Machine, real: str, poses: int, rng: np.random.Generator, folder: Path
) -> Tally:
    """Ask a platform's or an arm's code."""
    mechanism = with_limbs(machine.mechanism, "firmware", "")
    plain = PlainMechanism(tomllib.loads(mechanism_to_toml(mechanism)))
    tally = Tally(mechanism.name, machine.kind, real)
    library = built(machine, real, folder)
    limbs = Limbs(plain, rng)
    x = np.vstack([closed_configurations(plain, poses // 2, spread, rng) for spread in (0.05, 0.3)])
    if not len(x):
        return tally
    on, number, count = limbs.poses(x), len(mechanism.actuated), len(x)
    units = np.array([1.0 if c.is_angular else plain.size for c in mechanism.actuated])
    targets = [on, limbs.moved(on)]
    if not plain.serial:
        targets.append(projected(plain, limbs.moved(on)))
    goals, begin = np.vstack(targets), np.vstack([x] * len(targets))

    def of_joints(at: np.ndarray, joints: np.ndarray) -> np.ndarray:
        return limbs.gaps(begin[at], goals[at], joints)

    joints = np.vstack([limbs.joints(x)] * 2)
    if plain.serial:
        # from beside the answer
        guesses = joints + 0.05 * rng.normal(size=joints.shape) * units
        _ask(tally, library.ask_all, "inverse", [goals, guesses], number, of_joints, count)
        return tally
    _ask(tally, library.back_all, "inverse", [goals], number, of_joints, count)
    joints[count:] += 0.3 * rng.normal(size=(count, number)) * units
    home = limbs.poses(plain.reference[None]) if machine.home is None else np.array([machine.home])

    def of_poses(at: np.ndarray, found: np.ndarray) -> np.ndarray:
        return limbs.gaps(begin[at], found, joints[at])

    guesses = np.tile(home, (len(joints), 1))
    _ask(tally, library.ask_all, "direct", [joints, guesses], 7, of_poses)
    return tally


# --- maps -----------------------------------------------------------------------------------------


def of_map(
    machine: Machine, real: str, poses: int, rng: np.random.Generator, folder: Path
) -> Tally:
    """Ask a map's code, both ways."""
    mechanism = machine.mechanism
    tally = Tally(f"{mechanism.name}", "map", real)
    library = built(machine, real, folder)
    file = folder / "plain.toml"
    file.write_text(mechanism_to_toml(mechanism))
    g = plain_graph.read(file)
    places = [[g.place(n) for n in part] for part in (machine.given, machine.find)]
    units = np.array([1.0 if c.angle else g.size for c in g.coordinates])
    near = np.vstack([plain_graph.generic(g, poses // 2, spread, seed=1) for spread in (0.05, 0.3)])
    if not len(near):
        return tally
    values = g.values(near) * units
    home = np.array([c.zero for c in g.coordinates]) * units
    for what, function, known, wanted in (
        ("direct", library.ask_all, *places),
        ("inverse", library.ask_inverse, *reversed(places)),
    ):
        on, both = values[:, known], [*known, *wanted]
        goals = np.vstack([on, on + rng.normal(size=on.shape) * units[known]])
        guesses = np.vstack([values[:, wanted], np.tile(home[wanted], (len(near), 1))])

        def gaps(at: np.ndarray, found: np.ndarray, goals=goals, both=both) -> np.ndarray:  # type: ignore[no-untyped-def]
            numbers = np.hstack([goals[at], found]) / units[both]
            return np.array(
                [
                    _graph_gap(g, near[k % len(near)], dict(zip(both, row, strict=True)), rng)
                    for k, row in zip(at, numbers.tolist(), strict=True)
                ]
            )

        _ask(tally, function, what, [goals, guesses], len(wanted), gaps, len(near))
    return tally


def _graph_gap(
    g: plain_graph.Graph, x: np.ndarray, fixed: dict[int, float], rng: np.random.Generator
) -> float:
    """How far from closing a graph is at best with fixed coordinates: from a configuration, then
    from random starts.
    """
    start = x[None].copy()
    for k, value in fixed.items():
        start[:, 7 * len(g.names) + k] = value
    columns = np.setdiff1d(np.arange(g.freedom), [6 * len(g.names) + k for k in fixed])
    gap = float(np.max(np.abs(g.closure(plain_graph.solve(g, start, columns))[0])))
    if gap > 1e-6:
        many = plain_graph.solve(g, plain_graph.random_starts(g, 4 * STARTS, fixed, rng), columns)
        gap = min(gap, float(np.max(np.abs(g.closure(many)[0]), axis=1).min()))
    return gap


# --- machines -------------------------------------------------------------------------------------


def as_limbs(name: str, limbs: tuple[tuple[str, ...], ...]) -> Mechanism:
    """A shipped loop of a graph as limbs that meet at a platform."""
    data = tomllib.loads(mechanism_to_toml(symkin.load(name)))
    joints = {
        joint["name"]: {k: v for k, v in joint.items() if k != "links"} for joint in data["joint"]
    }
    kept = {key: data[key] for key in ("format", "length_unit", "angle_unit")} | {
        "name": f"{name}_limbs"
    }
    at = joints[limbs[0][-1]]["point"]
    tables = [
        {"name": f"limb{i}", "joint": [joints[j] for j in chain]} for i, chain in enumerate(limbs)
    ]
    with tempfile.TemporaryDirectory() as scratch:
        file = Path(scratch) / "m.toml"
        file.write_text(to_toml(kept | {"platform": {"position": at}, "limb": tables}))
        return symkin.load(file)


def named() -> Iterator[Machine]:
    """Shipped machines and those of bench/machines."""
    yield from map(machine_of, (*PLATFORMS, *ARMS))
    for file in sorted(PLACE.glob("*.toml")):
        made = symkin.load(file)
        yield Machine(made)
        if made.motion != "spatial":
            # the same without its motion: its pose is then of six numbers, of which its limbs leave
            # some
            yield Machine(replace(made, name=f"{made.name}_six", motion="spatial"))
    for name, limbs in LOOPS.items():
        yield Machine(as_limbs(name, limbs))
    yield from map(machine_of, MAPS)


def drawn(seed: int, folder: Path) -> Iterator[Machine]:
    """Random machines: two of three of limbs, one a map of a graph."""
    for number in range(10_000):
        rng = np.random.default_rng([seed, number])
        file = folder / f"r{number}.toml"
        try:
            file.write_text(Drawing(rng).grow() if number % 3 == 2 else to_toml(random_file(rng)))
            text = file.read_text()
            file.write_text(
                text.replace('name = "m"', f'name = "r{number}"', 1).replace(
                    'name = "graph"', f'name = "r{number}"', 1
                )
            )
            mechanism = symkin.load(file)
            if number % 3 != 2:
                yield Machine(mechanism)
                continue
            names = [c.name for c in mechanism.coordinates if c.kind != "quaternion"]
            mobility = symkin.mobility(mechanism).mobility
            if 0 < mobility <= 3 and len(names) >= 2 * mobility:
                chosen = [str(n) for n in rng.permutation(names)[: 2 * mobility]]
                yield Machine(mechanism, tuple(chosen[:mobility]), tuple(chosen[mobility:]))
        except (SymkinError, InputError):
            continue


@dataclass
class Campaign:
    """What all machines came to."""

    poses: int
    seed: int
    only: str
    kind: str
    tallies: list[Tally] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)
    machines: int = 0

    def ask(self, machines: Iterator[Machine], most: int) -> None:
        """Ask so many machines."""
        done = 0
        while done < most and (machine := next(machines, None)) is not None:
            if machine.mechanism.name.startswith(self.only) and self.kind in ("", machine.kind):
                done += self._asked(machine)
        self.machines += done

    def _asked(self, machine: Machine) -> bool:
        """Ask the code of both types; False where there is none, or not in time."""
        found = []
        for real in ("float", "double"):
            with tempfile.TemporaryDirectory() as scratch:
                signal.setitimer(signal.ITIMER_PROF, SECONDS)
                try:
                    of = of_map if machine.given else of_limbs
                    found.append(
                        of(
                            machine,
                            real,
                            self.poses,
                            np.random.default_rng(self.seed),
                            Path(scratch),
                        )
                    )
                except (InputError, TimeoutError) as reason:
                    print(
                        f"  {machine.mechanism.name} {real}: left out: {str(reason)[:200]}",
                        flush=True,
                    )
                    if OWN_TEST in str(reason):
                        self.failed.append(f"{machine.mechanism.name} {real}")
                finally:
                    signal.setitimer(signal.ITIMER_PROF, 0.0)
        for tally in found:
            self.tallies.append(tally)
            print(tally.line(), *(f"\n    {e}" for e in tally.examples[:3]), flush=True)
        return bool(found)

    def ends(self) -> int:
        """Print the last line; the exit status."""
        false, still = sum(t.open for t in self.tallies), sum(t.moved for t in self.tallies)
        taken, feasible = (
            sum(t.on_set_ok for t in self.tallies),
            sum(t.on_set for t in self.tallies),
        )
        print(
            f"{self.machines} machines, {sum(t.calls for t in self.tallies)} calls, "
            f"{sum(t.ok for t in self.tallies)} OK, of which {false} "
            f"do not close; own tests that fail: {len(self.failed)} "
            f"({', '.join(self.failed) or 'none'}); refusals of standing still: {still}; "
            f"feasible values taken {taken} of {feasible}"
        )
        return 1 if false or self.failed or still else 0


def late(*_: object) -> None:
    raise TimeoutError("not in time")


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--random", type=int, default=30, help="random machines")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--poses", type=int, default=60)
    parser.add_argument("--only", default="", help="machines whose names begin so")
    parser.add_argument(
        "--kind", default="", choices=("map", "arm", "platform"), help="machines of one kind"
    )
    parser.add_argument("--no-named", action="store_true", help="random machines alone")
    chosen = parser.parse_args()
    signal.signal(signal.SIGPROF, late)
    campaign = Campaign(chosen.poses, chosen.seed, chosen.only, chosen.kind)
    with tempfile.TemporaryDirectory() as scratch:
        if not chosen.no_named:
            campaign.ask(named(), 1000)
        campaign.ask(drawn(chosen.seed, Path(scratch)), chosen.random)
    return campaign.ends()


if __name__ == "__main__":
    sys.exit(main())
