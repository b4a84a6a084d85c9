"""One machine in many spellings: are its modes, its counts, statements, certificates and times one?

    python tests/campaigns/spellings.py [--machine NAME ...] [--spelling NAME ...] [--json]
        [--direction direct inverse] [--firmware [--goals 40]] [--seed 0] [--jobs 1] [--limit 120]

Each machine is asked in both directions, in every spelling that it has: limbs and graph, with the
motion declared and without, joints and DH, MJCF and URDF, R R for U, another unit, order, place,
reference and size, a named point. Modes are compared as places of links, turned back to the first
spelling of their kind. Times are processor times of warm calls, medians of batches, told with their
ratio to the least of their kind. Where two lists of modes differ, independent closures and
random starts (`twin_oracle`) say of each mode whether it closes and of each configuration found
whether it is listed. Exit status 1 where modes, statements, complex counts or certificates differ.

With `--firmware` it is the generated C (double) of each spelling: the operations of each function
at most, beside the least of its kind; those that the turn of a turned base takes of poses and
twists are left out of the ratio. Compiled, it is asked random goals (`--goals`) in both directions:
shares that are OK, and answers that are not on the machine by `modes`. Exit status 1 where a ratio
is above 1.05, a share is below that of another spelling, an answer is wrong, a spelling refused.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import symkin
from campaigns.children import run_each
from campaigns.twin_oracle import CLOSED, Oracle, numbers_only, oracle_of
from campaigns.twin_oracle import SAME as SAME_FEATURES
from helpers.spelled_code import Answered, Goals, answered, border_of, operations
from helpers.spellings import MACHINES, Machine, Spelling, lacking, named, spellings

DIRECTIONS = ("direct", "inverse")
BATCHES, BATCH_S = 5, 0.1
"""Batches of warm calls whose median is told, and seconds of each, one call at least."""
SAME_COST = 1.05
"""Operations of a spelling, over those of the best, that are as few."""
STARTS = 600
"""Random starts of the independent search."""


@dataclass
class Answer:
    """What one spelling answers in one direction; `away` tells how many modes it lacks of the first
    spelling of its kind, and how many more it has.
    """

    machine: str
    direction: str
    spelling: str
    kind: str
    modes: int = 0
    complex_count: int | None = None
    completeness: str = ""
    certified: int = 0
    method: str = ""
    first_s: float = 0.0
    warm_s: float = float("nan")
    ratio: float = float("nan")
    away: tuple[int, int] = (0, 0)
    notes: tuple[str, ...] = ()
    fault: str | None = None
    verdict: str = ""
    places: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def claims(self) -> tuple[Any, ...]:
        """What must be the same in all spellings of a kind."""
        told = (self.modes, self.complex_count, self.completeness, self.certified)
        return (*told, self.fault is None)


def asked(machine: Machine, spelling: Spelling, direction: str) -> Answer:
    """What a spelling answers, with the processor time that it takes."""
    inverse = direction == "inverse"
    begin = time.process_time()
    found = spelling.modes(machine, inverse=inverse)
    first = time.process_time() - begin
    return Answer(
        machine.name,
        direction,
        spelling.name,
        spelling.kind,
        modes=len(found),
        complex_count=found.complex_count,
        completeness=found.completeness,
        certified=sum(bool(mode.certified) for mode in found),
        method=found.method,
        first_s=first,
        warm_s=_warm(lambda: spelling.modes(machine, inverse=inverse)),
        notes=found.notes,
        places=spelling.configurations(machine, found),
    )


def _warm(call: Callable[[], object]) -> float:
    """The processor time of a call: the median of batches that coarse clocks can tell."""
    times = []
    for _ in range(BATCHES):
        begin, now, calls = time.process_time(), time.perf_counter(), 0
        while not calls or time.perf_counter() < now + BATCH_S:
            call()
            calls += 1
        times.append((time.process_time() - begin) / calls)
    return statistics.median(times)


# --- who is right ---------------------------------------------------------------------------------


def judged(machine: Machine, spelling: Spelling, direction: str) -> str:
    """What an independent closure of a spelling says of its list: modes that do not close, and
    configurations from random starts that it lacks.
    """
    data = numbers_only(tomllib.loads(spelling.mechanism.to_toml()))
    oracle = oracle_of(data)
    found = spelling.modes(machine, inverse=direction == "inverse")
    fits = [oracle.fitted(_printed(mode)) for mode in found]
    still_open = sum(not left < CLOSED for left, _ in fits)
    listed = [oracle.features(x) for _, x in fits]
    searched = list(oracle.others(_given(oracle, found), STARTS))
    missing = sum(
        all(np.max(np.abs(f - one)) > SAME_FEATURES for one in listed)
        for f in map(oracle.features, searched)
    )
    return (
        f"{still_open} of {len(found)} modes do not close; {STARTS} starts find {len(searched)}, "
        f"{missing} of them missing"
    )


def _printed(mode: symkin.Solution) -> dict[str, Any]:
    pose = [*map(float, mode.position), *map(float, mode.quaternion)]
    return {"pose": pose, "joints": mode.printed_joints}


def _given(oracle: Oracle, found: symkin.Modes) -> dict[str, Any]:
    told = found.given
    if "joints" not in told or not isinstance(told["joints"], dict):
        return told
    return {"joints": [told["joints"][name] for name in oracle.actuated]}


# --- the table ------------------------------------------------------------------------------------


def answers(options: argparse.Namespace) -> Iterator[list[Answer]]:
    """The answers of each machine in each direction."""
    for machine, spelled in asked_for(options):
        for direction in options.direction:
            yield _in_children(machine, spelled, direction, options)


def asked_for(options: argparse.Namespace) -> Iterator[tuple[Machine, list[Spelling]]]:
    """The machines and spellings that the options name."""
    for name in options.machine or MACHINES:
        machine = replace(MACHINES[name](), seed=options.seed)
        with tempfile.TemporaryDirectory() as folder:
            yield machine, named(list(spellings(machine, Path(folder))), options.spelling)


def _in_children(
    machine: Machine, spelled: Sequence[Spelling], direction: str, options: argparse.Namespace
) -> list[Answer]:
    """The answers of all spellings, each in a process of its own, compared and judged."""

    def ask(place: int, send: Callable[[Any], None]) -> None:
        try:
            send(asked(machine, spelled[place], direction))
        except symkin.SymkinError as error:
            send(_empty(machine, spelled[place], direction, f"refused: {error}"))

    found: dict[int, Answer] = {}
    for ended in run_each(range(len(spelled)), ask, options.jobs, options.limit):
        found[ended.task] = (
            ended.sent[0]
            if ended.sent
            else _empty(machine, spelled[ended.task], direction, ended.fault or "no answer")
        )
    table = [found[place] for place in range(len(spelled))]
    first: dict[str, Answer] = {}
    for answer in table:
        alike = (a.warm_s for a in table if a.fault is None and a.kind == answer.kind)
        answer.ratio = answer.warm_s / max(min(alike, default=float("nan")), 1e-9)
        if answer.fault is None:
            home = first.setdefault(answer.kind, answer)
            answer.away = _away(home, answer)
    _judge(machine, spelled, direction, table, options)
    return table


def _away(home: Answer, other: Answer) -> tuple[int, int]:
    counts = (home.modes, other.modes)
    return (
        len(lacking(home.places, other.places, counts)),
        len(lacking(other.places, home.places, counts[::-1])),
    )


def _judge(
    machine: Machine,
    spelled: Sequence[Spelling],
    direction: str,
    table: list[Answer],
    options: argparse.Namespace,
) -> None:
    """Add what the third method says of the first spelling of a kind and of those with other
    modes.
    """
    kinds = {a.kind for a in table if any(a.away)}
    seen: set[tuple[Any, ...]] = set()
    doubtful = []
    for place, answer in enumerate(table):
        key = (answer.kind, answer.away, answer.modes)
        if answer.kind in kinds and answer.fault is None and key not in seen:
            seen.add(key)
            doubtful.append(place)

    def judge(place: int, send: Callable[[Any], None]) -> None:
        try:
            send(judged(machine, spelled[place], direction))
        except Exception as error:
            send(f"the third method failed: {type(error).__name__}: {error}")

    for ended in run_each(doubtful, judge, options.jobs, options.limit):
        table[ended.task].verdict = ended.sent[0] if ended.sent else str(ended.fault)


def _empty(machine: Machine, spelling: Spelling, direction: str, fault: str) -> Answer:
    return Answer(machine.name, direction, spelling.name, spelling.kind, fault=fault)


def differing(table: Sequence[Answer]) -> set[int]:
    """Places of answers that are not those of most spellings of their kind."""
    usual: dict[str, tuple[Any, ...]] = {}
    for kind in {a.kind for a in table}:
        counted = Counter(a.claims for a in table if a.kind == kind)
        usual[kind] = counted.most_common(1)[0][0]
    return {k for k, a in enumerate(table) if a.claims != usual[a.kind] or any(a.away)}


def printed(table: Sequence[Answer]) -> None:
    """Write a table, differences marked."""
    marked = differing(table)
    print(f"\n{table[0].machine}, {table[0].direction}: {len(marked)} of {len(table)} differ")
    for place, a in enumerate(table):
        claims = f"{a.modes:4d} of {a.complex_count!s:>5}  {a.completeness:15} {a.certified:4d}"
        times = f"{1e3 * a.warm_s:9.2f} ms {a.ratio:6.2f}  first {a.first_s:6.2f} s"
        mark = "*" if place in marked else " "
        line = f"{mark} {a.spelling:24} {a.kind:9} "
        line += a.fault[:90] if a.fault else f"{claims}  {times}  {a.method}"
        if any(a.away):
            line += f"; lacks {a.away[0]}, has {a.away[1]} more"
        print(line + (f"\n    {a.verdict}" if a.verdict else ""), flush=True)


# --- generated C ----------------------------------------------------------------------------------


@dataclass
class Code:
    """What the C of one spelling costs and answers: `ratio` is the worst of its functions,
    `function`.
    """

    machine: str
    spelling: str
    kind: str
    operations: Mapping[str, int] = field(default_factory=dict)
    answered: Answered | None = None
    ratio: float = float("nan")
    function: str = ""
    fault: str | None = None


def coded(machine: Machine, spelled: Sequence[Spelling], options: argparse.Namespace) -> list[Code]:
    """The C of all spellings of a machine, each in a process of its own, compared."""
    kinds: dict[str, Goals] = {}
    for one in spelled:
        kinds.setdefault(one.kind, Goals.of(machine, one, options.goals))

    def make(place: int, send: Callable[[Any], None]) -> None:
        one = spelled[place]
        code = Code(machine.name, one.name, one.kind)
        try:
            code.operations = operations(one.mechanism)
            if options.goals:
                code.answered = answered(kinds[one.kind], one)
        except symkin.SymkinError as error:
            code.fault = f"refused: {error}"
        send(code)

    found: dict[int, Code] = {}
    for ended in run_each(range(len(spelled)), make, options.jobs, options.limit):
        one = spelled[ended.task]
        lost = Code(machine.name, one.name, one.kind, fault=ended.fault or "no answer")
        found[ended.task] = ended.sent[0] if ended.sent else lost
    table = [found[place] for place in range(len(spelled))]
    for code, one in zip(table, spelled, strict=True):
        best = least([a.operations for a in table if a.kind == code.kind])
        ratios = {
            name: (count - one.is_turned * border_of(name, machine)) / max(best[name], 1)
            for name, count in code.operations.items()
        }
        code.function = max(ratios, key=lambda name: ratios[name], default="")
        code.ratio = ratios.get(code.function, float("nan"))
    return table


def least(counts: Sequence[Mapping[str, int]]) -> dict[str, int]:
    """The least operations of each function."""
    return {
        name: min(one[name] for one in counts if name in one) for part in counts for name in part
    }


def unlike(table: Sequence[Code]) -> set[int]:
    """Places of spellings that cost more than the best, accept less, are refused or answer
    wrongly.
    """
    most: dict[str, float] = {}
    for code in table:
        most[code.kind] = max(most.get(code.kind, 0.0), _share(code))
    return {
        k
        for k, code in enumerate(table)
        if code.fault
        or code.ratio > SAME_COST
        or (code.answered and code.answered.wrong)
        or _share(code) * SAME_COST < most[code.kind]
    }


def _share(code: Code) -> float:
    """The share of goals that are OK, of both directions together."""
    return code.answered.direct + code.answered.inverse if code.answered else 0.0


def printed_code(table: Sequence[Code]) -> None:
    """Write a table of C, first the least operations of each kind."""
    marked = unlike(table)
    print(f"\n{table[0].machine}, C: {len(marked)} of {len(table)} marked")
    for kind in dict.fromkeys(code.kind for code in table):
        best = least([code.operations for code in table if code.kind == kind])
        print("  least" + (f" {kind}" if kind else "") + f": {dict(best)}")
    for place, code in enumerate(table):
        line = f"{'*' if place in marked else ' '} {code.spelling:24} {code.kind:9} "
        line += code.fault or f"{code.ratio:6.3f} {code.function}"
        if code.answered:
            direct, inverse, wrong = asdict(code.answered).values()
            line += f"; direct {100 * direct:.0f} %, inverse {100 * inverse:.0f} %, {wrong} wrong"
        print(line, flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--machine", nargs="*", choices=MACHINES, default=[])
    parser.add_argument("--spelling", nargs="*", default=[], help="names of spellings")
    parser.add_argument("--direction", nargs="*", choices=DIRECTIONS, default=list(DIRECTIONS))
    parser.add_argument("--firmware", action="store_true", help="the C of each spelling")
    parser.add_argument("--goals", type=int, default=40, help="that C is asked, 0: none")
    parser.add_argument("--seed", type=int, default=0, help="of the input")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--limit", type=float, default=120.0, help="seconds a spelling")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    count, told = 0, list[dict[str, Any]]()
    if options.firmware:
        for machine, spelled in asked_for(options):
            code = coded(machine, spelled, options)
            count += len(unlike(code))
            told += map(asdict, code)
            if not options.json:
                printed_code(code)
    for table in () if options.firmware else answers(options):
        count += len(differing(table))
        if options.json:
            told += [{k: v for k, v in asdict(a).items() if k != "places"} for a in table]
        else:
            printed(table)
    if options.json:
        print(json.dumps(told))
    return int(bool(count))


if __name__ == "__main__":
    sys.exit(main())
