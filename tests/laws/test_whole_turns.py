"""Branches that come back to themselves after whole turns of the given angles: many turns are as
right as few, and cheap."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate_but
from helpers.inside import block_follower

# machine, what is given at the start, and by how many degrees it moves
PATHS = [
    ("four_bar", {"crank": 90.0}, {"crank": 3 * 360.0 + 77.0}),
    ("four_bar", {"crank": 90.0}, {"crank": -3 * 360.0 - 10.0}),
    ("bennett", {"input": 5.0}, {"input": -2 * 360.0 - 200.0}),
    (
        "planetary_gear",
        {"sun": 0.0, "ring": 0.0},
        {"sun": 4 * 360.0 + 100.0, "ring": 2 * 360.0 + 50.0},
    ),
]


def _geared() -> symkin.Mechanism:
    """A crank and rocker behind a gear: two turns of the motor are one of the crank, so that one
    turn of the motor leads to another mode."""
    z = (0.0, 0.0, 1.0)

    def joint(name: str, at: tuple[float, float], links: tuple[str, str]) -> symkin.LinkJoint:
        return symkin.LinkJoint(
            symkin.Joint(name, "R", (*at, 0.0), z, actuated=name == "motor"), links
        )

    joints = [
        joint("motor", (-50.0, 0.0), ("base", "gear")),
        joint("crank", (0.0, 0.0), ("base", "arm")),
        joint("crank_pin", (0.0, 40.0), ("arm", "coupler")),
        joint("rocker_pin", (99.0, 60.0), ("coupler", "rocker")),
        joint("rocker", (110.0, 0.0), ("base", "rocker")),
    ]
    return symkin.Mechanism(
        "geared",
        link_joints=joints,
        couplings=[symkin.Coupling("motor", {"crank": 2.0})],
        angle_unit="deg",
    )


def _scalars(sample: Any) -> np.ndarray:
    return np.array([v for v in sample.joints.values() if np.ndim(v) == 0])


def _agree(
    mechanism: symkin.Mechanism, start: dict[str, float], by: dict[str, float], samples: int
) -> None:
    """A path without samples between has the end, all turns counted, and the nearest place of
    one whose intervals hold no whole turn."""
    given = {name: [value, value + by[name]] for name, value in start.items()}
    once = symkin.track(mechanism, given=given)
    plain = symkin.track(mechanism, given=given, samples=samples)
    assert once.reached
    assert plain.reached
    assert _scalars(once.end) == pytest.approx(_scalars(plain.end), abs=1e-9)
    assert once.certified == plain.certified
    if once.nearest is not None and plain.nearest is not None:
        assert once.nearest.smallest_singular_value == pytest.approx(
            plain.nearest.smallest_singular_value, rel=1e-6
        )


@pytest.mark.parametrize(("name", "start", "by"), in_gate_but(PATHS, PATHS[1:2]))
def test_turns_at_once_are_turns_one_by_one(
    name: str, start: dict[str, float], by: dict[str, float]
) -> None:
    """Joints that the closure leaves out too, whichever way the given angles turn."""
    _agree(symkin.load(name), start, by, samples=17)


def test_a_turn_that_leads_to_another_mode_is_followed_until_it_comes_back() -> None:
    """After one turn of the motor the crank has made half of one."""
    _agree(_geared(), {"motor": 10.0}, {"motor": 5 * 360.0 + 200.0}, samples=40)
    found = symkin.track(_geared(), given={"motor": [10.0, 10.0 + 720.0 * 1000 + 360.0]})
    assert found.reached
    assert found.end.joints["crank"] - found.samples[0].joints["crank"] == pytest.approx(
        360.0 * 1000 + 180.0
    )


def test_thousands_of_turns_take_the_steps_of_one() -> None:
    """And the end is the configuration of the same angle within the first turn, as many turns
    on."""
    mechanism = symkin.load("four_bar")
    few = symkin.track(mechanism, given={"crank": [90.0, 90.0 + 360.0 + 50.0]})
    many = symkin.track(mechanism, given={"crank": [90.0, 90.0 + 360.0 * 5001 + 50.0]})
    assert many.reached
    assert many.certified
    assert many.steps <= few.steps
    turned = (_scalars(many.end) - _scalars(few.end)) / 360.0
    assert turned == pytest.approx(np.round(turned), abs=1e-9)
    assert set(np.abs(np.round(turned))) == {0.0, 5000.0}


def test_limits_hold_in_later_turns(tmp_path: Path) -> None:
    """A coupler pin that turns along meets a limit in its third turn."""
    mechanism = symkin.load("four_bar")
    text = mechanism.to_toml().replace(
        'name = "crank_pin"', 'name = "crank_pin"\nlimits = [-1000.0, 10.0]'
    )
    (tmp_path / "limited.toml").write_text(text)
    found = symkin.track(symkin.load(tmp_path / "limited.toml"), given={"crank": [90.0, 3690.0]})
    assert found.stop is not None
    assert found.stop.limit is not None
    assert found.stop.limit.name == "crank_pin"
    assert found.end.joints["crank_pin"] == pytest.approx(-1000.0, abs=1e-6)


def test_the_cap_of_effort_is_no_singularity(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where steps run out the sentence says so, and what to do; as many samples as it asks for
    lead to the end."""
    monkeypatch.setattr(block_follower, "MOST_EFFORT", 30)
    mechanism = symkin.load("four_bar")
    found = symkin.track(mechanism, given={"crank": [90.0, 440.0]})
    assert found.stop is not None
    assert found.stop.kind == "unproved"
    assert "--samples" in str(found.stop)
    assert "singularity is very near" not in str(found.stop)
    assert symkin.track(mechanism, given={"crank": [90.0, 440.0]}, samples=9).reached
