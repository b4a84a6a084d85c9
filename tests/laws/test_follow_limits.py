"""Joint limits along a track."""

from __future__ import annotations

import math
from dataclasses import replace

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
