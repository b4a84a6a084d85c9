"""Results travel: what the verbs return comes back from a process pool, and from copy and deepcopy,
as it was.
"""

from __future__ import annotations

import copy
import math
import multiprocessing
import pickle
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers.gate import each_once
from helpers.inside import (
    Noise,
    NotFittedError,
    Plan,
    Workspace,
    build_closure,
    build_problem,
    fit_file,
    read_measurements,
    velocity_equations,
)
from helpers.samples import five_bar, three_rrr
from symkin import (
    InputError,
    Measurements,
    Mechanism,
    Pose,
    SolveError,
    mode_graph,
    plan_measurements,
    singular_loci,
)

BARS = five_bar()


def measured() -> Measurements:
    """Five tips of the five-bar with its cranks 0.1 longer, from two circles."""
    angles = np.radians([[80, 100], [90, 90], [100, 70], [70, 120], [85, 95], [110, 80], [75, 105]])
    tips = []
    for one, two in angles:
        a, b = (
            60.1 * np.array([math.cos(one), math.sin(one)]),
            60.1 * np.array([math.cos(two), math.sin(two)]) + [100, 0],
        )
        half, normal = (b - a) / 2, np.array([-(b - a)[1], (b - a)[0]]) / np.linalg.norm(b - a)
        tips.append([*(a + half + math.sqrt(6400 - half @ half) * normal), 0.0])
    return Measurements(angles, position=np.array(tips), position_sigma=0.01)


def planned(workspace: Workspace) -> Plan:
    readings, names = ("position", "orientation"), ["limb1.q1.point.x"]
    return plan_measurements(
        workspace,
        4,
        Noise(position=0.01, orientation=0.01),
        groups=0,
        readings=readings,
        parameters=names,
    )


def failing() -> SolveError:
    with pytest.raises(SolveError) as error:
        symkin.solve(BARS, joints=[170.0, 10.0])
    return error.value


@lru_cache(maxsize=1)
def results() -> dict[str, Any]:
    """One of each public result."""
    tip = symkin.solve(BARS, joints=[80.0, 100.0])
    stopped = symkin.track(BARS, joints=[[90.0, 90.0], [170.0, 10.0]], samples=3, name_modes=False)
    jacobians = {
        f"jacobian {kind}": symkin.jacobian(BARS, kind)
        for kind in ("direct", "inverse", "analytic", "passive")
    }
    workspace = Workspace.about(three_rrr("planar"))
    plan = planned(workspace)
    return {
        "mechanism": BARS,
        "pose": Pose(np.array([1.0, 2.0, 3.0]), np.array([1.0, 0, 0, 0])),
        "solve": tip,
        "solution": tip.solution,
        "modes": symkin.modes(BARS, joints=[80.0, 100.0], method="multistart", starts=30),
        **jacobians,
        "jacobian of the geometry": symkin.jacobian(BARS, "direct", parameters=True),
        "velocity equations": velocity_equations(BARS, 1.0, bound=False),
        "track": symkin.track(BARS, joints=[[80.0, 100.0], [90.0, 90.0]]),
        "stopped track": stopped,
        "singularity": symkin.singularity(tip.solution),
        "loci": singular_loci(tip.solution, ("q1", "q2"), starts=2),
        "mode graph": mode_graph(BARS, [("q1", 80, 90), ("q2", 90, 100)], 2, joints=[85.0, 95.0]),
        "mobility": symkin.mobility(BARS),
        "calibration": symkin.calibrate(
            BARS, measured(), parameters=["left.q1.point.x", "left.b1.point.y"]
        ),
        "measurements": measured(),
        "workspace": workspace,
        "plan": plan,
        "error": failing(),
        "not fitted": NotFittedError("no fit", ("the sign of q1 looks reversed",)),
        "closure": build_closure(BARS),
        "problem": build_problem(BARS, "direct"),
    }


NAMES = (
    "mechanism",
    "pose",
    "solve",
    "solution",
    "modes",
    "jacobian direct",
    "jacobian inverse",
    "jacobian analytic",
    "jacobian passive",
    "jacobian of the geometry",
    "velocity equations",
    "track",
    "stopped track",
    "singularity",
    "loci",
    "mode graph",
    "mobility",
    "calibration",
    "measurements",
    "workspace",
    "plan",
    "error",
    "not fitted",
    "closure",
    "problem",
)


def numbers(value: Any, seen: tuple[int, ...] = ()) -> Iterator[tuple[str, bytes]]:
    """All numbers and texts that a result holds, exactly; expressions by their size and their own
    text.
    """
    if id(value) in seen:
        return
    if isinstance(value, ca.SX | ca.DM):
        yield "expression", repr((value.shape, value.nnz())).encode()
    elif isinstance(value, np.ndarray):
        yield "array", repr(value.shape).encode() + value.tobytes()
    elif isinstance(value, Mapping):
        for key, item in value.items():
            yield from (
                (f"{key}: {name}", data) for name, data in numbers(item, (*seen, id(value)))
            )
    elif isinstance(value, tuple | list | frozenset):
        for item in sorted(value) if isinstance(value, frozenset) else value:
            yield from numbers(item, (*seen, id(value)))
    elif isinstance(value, BaseException):
        yield from numbers((str(value), vars(value)), (*seen, id(value)))
    elif is_dataclass(value):
        # results that were made of rows at their first use are not part of what travels
        for field in (f for f in fields(value) if f.name != "_made"):
            item = getattr(value, field.name)
            yield from (
                (f"{field.name}.{name}", data) for name, data in numbers(item, (*seen, id(value)))
            )
    else:
        yield type(value).__name__, repr(value).encode()


def same(value: Any) -> Any:
    return value


def texts(value: Any) -> tuple[Any, str]:
    """What a worker receives, and how it prints there."""
    return value, str(value)


def solved(mechanism: Mechanism, joints: list[float]) -> Any:
    return symkin.modes(mechanism, joints=joints, method="multistart", starts=30)


def refused(mechanism: Mechanism) -> Any:
    return symkin.solve(mechanism, joints=[170.0, 10.0])


@pytest.fixture(scope="module")
def pool() -> Iterator[ProcessPoolExecutor]:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as executor:
        yield executor


@pytest.mark.slow
def test_the_list_of_results_is_whole() -> None:
    assert tuple(results()) == NAMES


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_result_comes_back_from_a_process_pool(name: str, pool: ProcessPoolExecutor) -> None:
    """Equal numbers to the bit, and the same text there and here."""
    value = results()[name]
    back, text = pool.submit(texts, value).result()
    assert type(back) is type(value)
    assert list(numbers(back)) == list(numbers(value))
    assert text == str(value) == str(back)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "way"),
    each_once(NAMES, [copy.copy, copy.deepcopy, lambda v: pickle.loads(pickle.dumps(v))]),
)
def test_a_result_is_copied(name: str, way: Any) -> None:
    value = results()[name]
    assert list(numbers(way(value))) == list(numbers(value))


@pytest.mark.slow
def test_results_made_in_a_process_pool_are_those_made_here(pool: ProcessPoolExecutor) -> None:
    """Modes of a worker are the parent's; they work on, and an error arrives with its result."""
    joints = [80.0, 100.0]
    theirs, ours = pool.submit(solved, BARS, joints).result(), solved(BARS, joints)
    assert [list(numbers(mode)) for mode in theirs] == [list(numbers(mode)) for mode in ours]
    assert theirs.poses == ours.poses
    with pytest.raises(SolveError) as error:
        pool.submit(refused, BARS).result()
    assert error.value.result.status == failing().result.status


def test_a_jacobian_that_came_back_has_the_same_values(pool: ProcessPoolExecutor) -> None:
    """Evaluated, differentiated, and as a function of the geometry."""
    solution = results()["solution"]
    for name in ("jacobian direct", "jacobian of the geometry"):
        value = results()[name]
        back = pool.submit(same, value).result()
        assert np.array_equal(back.at(solution), value.at(solution))
        assert np.array_equal(back.hessian_at(solution), value.hessian_at(solution))
        assert [v.name for v in back.parameters] == [v.name for v in value.parameters]


@pytest.mark.slow
def test_a_calibration_report_comes_back(pool: ProcessPoolExecutor, tmp_path) -> None:
    """What `calibrate fit` writes is made from a report that has travelled."""
    m = measured()
    rows = [
        f"{math.degrees(a)},{math.degrees(b)},{x},{y},{z}"
        for (a, b), (x, y, z) in zip(m.joints, m.position, strict=True)
    ]
    path = tmp_path / "data.csv"
    path.write_text("\n".join(["q1[deg],q2[deg],x[mm],y[mm],z[mm]", *rows]), encoding="utf-8")
    report = fit_file(
        BARS,
        read_measurements(path, BARS),
        parameters="left.q1.point.x,left.b1.point.y",
        sigmas={"position": 0.01},
    )
    back, text = pool.submit(texts, report).result()
    assert text == str(report) == str(back)
    assert list(numbers(back)) == list(numbers(report))


def test_errors_keep_their_kind(pool: ProcessPoolExecutor) -> None:
    with pytest.raises(InputError, match="1 value given, five_bar has 2 actuated joints"):
        pool.submit(solved, BARS, [1.0]).result()
