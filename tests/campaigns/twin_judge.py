"""Say who is right where two checkouts differ: by independent closures and searches, not by age.

Modes are put into the independent closure, and many random starts of another solver look for what
either list lacks. A stronger claim (a certificate, a completeness, an answer in place of a refusal)
is right where nothing speaks against it, and wrong where something does.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from campaigns.twin_compare import Difference, slack
from campaigns.twin_oracle import CLOSED, REGULAR, SAME, Oracle, numbers_only, oracle_of

STARTS = 600
STRENGTH = {"proved": 3, "probability one": 2, "incomplete": 1, "sampled": 0}
"""Claims of completeness from the strongest to the weakest."""
MOVES, STANDS = 1e-4, 1e-4
"""Least motion, and least share of a singular value, that decide a kind of singularity."""
RATES = 1e-6
"""Largest error of a Jacobian against the independent closure, lengths over the size."""


@dataclass(frozen=True)
class Verdict:
    """Who is right ("old is right", "new is right", "neither", "undecided"), and why."""

    who: str
    why: str


@dataclass(frozen=True)
class Side:
    """What speaks against one side; nothing where it is empty."""

    faults: tuple[str, ...] = ()
    weaker: bool = False


def judged(difference: Difference) -> Verdict:
    """Who is right about a difference."""
    if difference.case is None:
        return Verdict("undecided", "nothing can be compared")
    judge = JUDGES.get(difference.kind.split()[0])
    if judge is None:
        return Verdict("undecided", "there is no third method for this")
    try:
        data = numbers_only(tomllib.loads(difference.case["toml"]))
        return judge(difference, oracle_of(data))
    except Exception as error:
        return Verdict("undecided", f"the third method failed: {type(error).__name__}: {error}")


def _verdict(old: Side, new: Side, otherwise: str) -> Verdict:
    """Who is right where something speaks against one side or both; of two sides that stand, the
    one that claims more.
    """
    why = "; ".join(
        f"{name}: {', '.join(side.faults)}"
        for name, side in (("old", old), ("new", new))
        if side.faults
    )
    if old.faults and new.faults:
        return Verdict("neither", why)
    if old.faults or new.faults:
        return Verdict("new is right" if old.faults else "old is right", f"{why}; {otherwise}")
    if old.weaker != new.weaker:
        return Verdict("new is right" if old.weaker else "old is right", otherwise)
    return Verdict("undecided", otherwise)


# --- modes ----------------------------------------------------------------------------------------


def _faults_of_list(
    oracle: Oracle, answer: Mapping[str, Any], found: list[np.ndarray]
) -> tuple[tuple[str, ...], str]:
    """What is wrong with a list of modes, and the largest closure error of those that close."""
    fits = [(*oracle.fitted(mode), slack(mode)) for mode in answer["modes"]]
    open_ones = [left for left, _, allowed in fits if not left < max(CLOSED, allowed)]
    faults = []
    if open_ones:
        faults.append(
            f"{len(open_ones)} modes do not close, by up to {max(open_ones):.1e} of the size"
        )
    listed = [oracle.features(x) for _, x, _ in fits]
    lacks = [
        f
        for f in map(oracle.features, found)
        if all(np.max(np.abs(f - other)) > SAME for other in listed)
    ]
    if lacks and len(answer["modes"]) == answer["count"]:
        faults.append(
            f"{len(lacks)} of {len(found)} configurations that random starts find are missing"
        )
    if answer["complex_count"] is not None and answer["count"] > answer["complex_count"]:
        faults.append(f"{answer['count']} modes of {answer['complex_count']} complex solutions")
    return tuple(faults), f"closes to {max((left for left, _, _ in fits), default=0.0):.1e}"


def _searched(difference: Difference, oracle: Oracle) -> list[np.ndarray]:
    """Configurations that random starts find: where something is given, and the machine is no arm
    whose joints are."""
    return list(oracle.others(difference.problem, STARTS))


def _lists(difference: Difference, oracle: Oracle) -> tuple[Side, Side, str]:
    found = _searched(difference, oracle)
    sides, told = [], []
    for name, answer in (("old", difference.old), ("new", difference.new)):
        faults, closes = _faults_of_list(oracle, answer, found)
        sides.append(Side(faults))
        told.append(f"{name} {closes}")
    return sides[0], sides[1], f"{', '.join(told)}; {STARTS} random starts find {len(found)}"


def _judge_modes(difference: Difference, oracle: Oracle) -> Verdict:
    return _verdict(*_lists(difference, oracle))


def _judge_completeness(difference: Difference, oracle: Oracle) -> Verdict:
    old, new, told = _lists(difference, oracle)
    strengths = [STRENGTH[side["completeness"]] for side in (difference.old, difference.new)]
    weaker = [s < max(strengths) for s in strengths]
    # what a weak list lacks is no fault of its statement
    sides = [
        Side(side.faults if not weak else tuple(f for f in side.faults if "missing" not in f), weak)
        for side, weak in zip((old, new), weaker, strict=True)
    ]
    return _verdict(sides[0], sides[1], told)


def _judge_count(difference: Difference, oracle: Oracle) -> Verdict:
    if max(side["count"] - len(side["modes"]) for side in (difference.old, difference.new)) > 0:
        return Verdict("undecided", "not all modes are listed")
    return _judge_modes(difference, oracle)


def _judge_state(difference: Difference, oracle: Oracle) -> Verdict:
    """An answer stands against a refusal, a crash or a hang where it is right."""
    answered = [
        not {"refused", "crashed", "ended"} & set(a) for a in (difference.old, difference.new)
    ]
    if not any(answered):
        return Verdict("undecided", "neither side answers")
    answer = difference.old if answered[0] else difference.new
    faults: tuple[str, ...] = ()
    told = "the other side has no answer"
    if "modes" in answer:
        faults, closes = _faults_of_list(oracle, answer, _searched(difference, oracle))
        told = f"the answer {closes}, {told}"
    elif "mobility" in answer and answer["mobility"] != oracle.mobility():
        faults = (f"mobility {answer['mobility']}, by the independent closure {oracle.mobility()}",)
    sides = [Side(faults) if ok else Side(weaker=True) for ok in answered]
    return _verdict(sides[0], sides[1], told)


# --- one mode -------------------------------------------------------------------------------------


def _held(difference: Difference, oracle: Oracle) -> list[str]:
    """The coordinates that stand while a problem is solved."""
    problem = difference.problem
    return (
        oracle.actuated
        if "joints" in problem
        else ["pose"]
        if "pose" in problem
        else list(problem["given"])
    )


def _judge_certified(difference: Difference, oracle: Oracle) -> Verdict:
    left, x = oracle.fitted(difference.mode or {})
    joints, pose, least = oracle.motions(x, _held(difference, oracle))
    moves = max(np.max(np.abs(joints), initial=0.0), np.max(np.abs(pose), initial=0.0)) > MOVES
    told = f"closes to {left:.1e}, least singular value {least:.1e} of the largest"
    fault = (
        ("a mode that moves or does not close is said to be proved",)
        if moves or left > CLOSED
        else ()
    )
    claims = [bool(side[difference.kind]) for side in (difference.old, difference.new)]
    sides = [
        Side(fault) if claim else Side(weaker=not fault and least > REGULAR) for claim in claims
    ]
    return _verdict(sides[0], sides[1], told)


def _judge_singularity(difference: Difference, oracle: Oracle) -> Verdict:
    """Type 2 by motions with the actuated (or given) coordinates held, type 1 with the pose
    held.
    """
    left, x = oracle.fitted(difference.mode or {})
    drive = list(difference.problem.get("given", {})) or oracle.actuated
    joints, pose, least = oracle.motions(x, drive)
    platform = bool(pose.size) and np.max(np.abs(pose), initial=0.0) > MOVES
    stuck, _, least_of_pose = (
        oracle.motions(x, ["pose"]) if oracle.has_platform else (joints[:0], pose, 1.0)
    )
    sides = []
    for side in (difference.old, difference.new):
        told, faults = side["singularity"], []
        if "refused" in told:
            sides.append(Side(weaker=True))
            continue
        says = {*told["kinds"], *(k for k, n in told["everywhere"].items() if n)}
        if platform and not says & {"type 2", "constraint"}:
            faults.append("the platform moves while the driving joints stand, no type 2 is told")
        if "type 2" in says and not len(pose) and least > STANDS:
            faults.append("type 2 is told where the driving joints determine all")
        if (
            "type 1" in says
            and "given" not in difference.problem
            and not len(stuck)
            and least_of_pose > STANDS
        ):
            faults.append("type 1 is told where the pose determines all")
        sides.append(Side(tuple(faults)))
    told = (
        f"closes to {left:.1e}; least singular values {least:.1e} (driving), {least_of_pose:.1e} "
        f"(pose)"
    )
    return _verdict(sides[0], sides[1], told)


def _pose_rates(twists: np.ndarray, pose: Sequence[float] | None) -> dict[str, np.ndarray]:
    """Twists, and the rates of pose coordinates: 2 q' = (0, w) q."""
    known = dict(zip(("vx", "vy", "vz", "wx", "wy", "wz"), twists, strict=True))
    if pose is None:
        return known
    w, u, spin = pose[3], np.array(pose[4:]), twists[3:]
    vector = 0.5 * (w * spin + np.cross(spin.T, u).T)
    known |= {
        "x": twists[0],
        "y": twists[1],
        "z": twists[2],
        "gamma": spin[2],
        "qw": -0.5 * u @ spin,
    }
    return known | dict(zip(("qx", "qy", "qz"), vector, strict=True))


def _judge_jacobian(difference: Difference, oracle: Oracle) -> Verdict:
    """Against all motions of the independent closure: J q' = t, and the like."""
    _, x = oracle.fitted(difference.mode or {})
    rates, twists = oracle.rates(x)
    known = _pose_rates(twists, (difference.mode or {})["pose"]) | rates
    kinds = difference.case["kinds"] if difference.case else {}
    size = oracle.size

    def unit(name: str) -> float:
        return (
            size
            if name in ("vx", "vy", "vz", "x", "y", "z") or kinds.get(name) == "length"
            else 1.0
        )

    errors = []
    for side in (difference.old["entries"], difference.new["entries"]):
        if "refused" in side:
            errors.append(None)
            continue
        rows = [r for r in side if r in known]
        if not rows or any(c not in known for r in rows for c in side[r]):
            return Verdict("undecided", "the independent closure has no such coordinates")
        worst = 0.0
        for r in rows:
            value = sum(np.nan if v is None else v * known[c] for c, v in side[r].items())
            worst = max(worst, float(np.max(np.abs(value - known[r]), initial=0.0)) / unit(r))
        errors.append(worst)
    told = ", ".join(
        f"{n} {'refuses' if e is None else f'{e:.1e}'}"
        for n, e in zip(("old", "new"), errors, strict=True)
    )
    sides = [
        Side(weaker=True)
        if e is None
        else Side(() if e < RATES else (f"rates are off by {e:.1e}",))
        for e in errors
    ]
    return _verdict(sides[0], sides[1], f"errors of rates: {told}")


# --- counts ---------------------------------------------------------------------------------------


def _judge_mobility(difference: Difference, oracle: Oracle) -> Verdict:
    truth = oracle.mobility()
    sides = [
        Side(() if side["mobility"] == truth else (f"mobility {side['mobility']}",))
        for side in (difference.old, difference.new)
    ]
    if truth is None:
        return Verdict("undecided", "the independent closure finds no closed configuration")
    return _verdict(sides[0], sides[1], f"the independent closure has mobility {truth}")


def _judge_rank(difference: Difference, oracle: Oracle) -> Verdict:
    from campaigns.twin_rank import rank_of

    case = difference.case or {}
    names = [side["parameters"] for side in (difference.old, difference.new)]
    ranks = [rank_of(case["toml"], case["calibration"], n) for n in names]
    if None in ranks:
        return Verdict("undecided", "a parameter has no number of its own in the file")
    sides = [
        Side(() if side["rank"] == rank else (f"rank {side['rank']}, by differences {rank}",))
        for side, rank in zip((difference.old, difference.new), ranks, strict=True)
    ]
    return _verdict(
        sides[0],
        sides[1],
        f"ranks by differences of the independent closure {ranks[0]}, {ranks[1]}",
    )


JUDGES: dict[str, Callable[[Difference, Oracle], Verdict]] = {
    "modes": _judge_modes,
    "count": _judge_count,
    "complex_count": _judge_count,
    "completeness": _judge_completeness,
    "unresolved_paths": _judge_completeness,
    "positive_dimensional": _judge_modes,
    "state": _judge_state,
    "certified": _judge_certified,
    "has_ground": _judge_certified,
    "singularity": _judge_singularity,
    "jacobian": _judge_jacobian,
    "mobility": _judge_mobility,
    "rank": _judge_rank,
}
"""The judge of each kind of difference."""
