"""Joint limits along a track."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

import symkin
from helpers import moved_points
from helpers.graph_twin import graph_twin
from helpers.samples import (
    COUPLER,
    CRANK,
    GROUND,
    ROCKER,
    bars,
)
from symkin import track


def test_limit_is_met_at_its_value_and_may_be_touched():
    """A path that passes a limit stops at it to 1e-9; one that only touches it goes on; limits may
    be ignored.
    """
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER, limits=(0.5, 1.2))
    crossing = track(mechanism, joints=[[1.0], [1.3]])
    assert crossing.stop is not None
    assert crossing.stop.kind == "limit"
    assert "crank" in crossing.statement
    assert abs(crossing.end.actuated[0] - 1.2) < 2e-9
    assert track(mechanism, joints=[[1.0], [1.2], [1.0]]).reached
    assert track(mechanism, joints=[[1.0], [1.3]], limits=False).reached
    assert track(mechanism, joints=[[1.25], [1.0]]).stop.kind == "limit"


def test_limits_hold_whole_turns_apart():
    """A crank within its limits but for a whole turn is within them, as in `solve`, and stops a
    turn beyond the limit.
    """
    mechanism = bars(GROUND, CRANK, COUPLER, ROCKER, limits=(0.5, 1.2))
    turn = 2 * math.pi
    assert track(mechanism, joints=[[1.0 + turn], [1.1 + turn]]).reached
    found = track(mechanism, joints=[[1.0 - turn], [1.3 - turn]])
    assert found.stop is not None
    assert found.stop.kind == "limit"
    assert "whole turn" in found.statement
    assert abs(found.end.actuated[0] - (1.2 - turn)) < 2e-9


def test_passive_limits_count_within_a_step():
    """A limit of an unknown that is passed and kept again between two samples stops the track."""
    plain = bars(100.0, 30.0, 90.0, 70.0)
    free = track(plain, joints=[[0.0], [2 * math.pi]], samples=60)
    swing = [s.joints["d"] for s in free.samples]
    rocker = replace(plain.limbs[1].joints[0], limits=(min(swing) - 0.1, max(swing) - 0.01))
    limited = replace(
        plain,
        limbs=[plain.limbs[0], replace(plain.limbs[1], joints=[rocker, plain.limbs[1].joints[1]])],
    )
    found = track(limited, joints=[[0.0], [2 * math.pi]])
    assert found.stop is not None
    assert found.stop.kind == "limit"
    assert found.stop.limit.name == "d"
    assert abs(found.end.joints["d"] - found.stop.limit.value) < 2e-9


@pytest.mark.parametrize("form", ["limbs", "graph"])
@pytest.mark.parametrize("by", ["joints", "poses"])
@pytest.mark.parametrize(("name", "beside"), [("c2", ""), ("c2", "r2"), ("r2", "c2")])
def test_limits_of_a_joint_at_which_a_loop_may_be_cut_stop_the_path(
    form: str, by: str, name: str, beside: str
) -> None:
    """The last joint of a limb is as much a joint as others, and others of its limb may have limits
    beside it.
    """
    home = moved_points.three_rpr()
    end = symkin.solve(home, joints=[84.0, 82.0, 92.0]).solution
    start = symkin.solve(home, joints=[78.0, 79.0, 81.0]).solution
    middle = 0.5 * (start.joints[name] + end.joints[name])
    rises = end.joints[name] > start.joints[name]
    limits = {name: (-3.0, middle) if rises else (middle, 3.0), beside: (-3.0, 3.0)}
    limbs = [
        replace(
            limb,
            joints=[
                replace(joint, limits=limits.get(joint.name, joint.limits)) for joint in limb.joints
            ],
        )
        for limb in home.limbs
    ]
    limited = replace(home, limbs=limbs)
    limited = graph_twin(limited) if form == "graph" else limited
    path = {by: [one.actuated_values if by == "joints" else one.pose for one in (start, end)]}
    found = track(limited, **path)
    assert found.stop.kind == "limit"
    assert found.stop.limit.name == name
    assert abs(found.end.joints[name] - middle) < 1e-8
    beyond = [(1 if rises else -1) * (s.joints[name] - middle) for s in found.samples]
    assert max(beyond) < 1e-8
    assert track(limited, limits=False, **path).reached
