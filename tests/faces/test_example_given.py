"""A worked example may give values by name, as `--given` does."""

from __future__ import annotations

from dataclasses import replace

import pytest

import symkin
from helpers.command_line import run_json
from helpers.inside import parse
from helpers.samples import five_bar, three_rps
from symkin import MechanismError


def with_example(mechanism: symkin.Mechanism, values: str) -> str:
    return mechanism.to_toml() + f"\n[example]\ngiven = {values}\n"


def test_the_example_is_used_where_nothing_is_given():
    """A suspension whose one motor leaves it a freedom: rack and height of the wheel are its
    example.
    """
    found = symkin.solve(symkin.load("five_link_suspension")).solution
    assert found.joints["rack"] == pytest.approx(5.0)
    assert found.position[2] == pytest.approx(330.0)


def test_limbs_may_have_such_an_example(capsys, tmp_path):
    """The place of a five-bar's tip, which is no direct and no inverse problem."""
    mechanism = parse(with_example(replace(five_bar(), motion="planar"), "{ x = 50.0, y = 110.0 }"))
    found = symkin.modes(mechanism)
    assert len(found) == 4
    assert found.given == {"x": 50.0, "y": 110.0}
    for mode in found:
        assert mode.position[:2] == pytest.approx([50.0, 110.0], abs=1e-6)
    (tmp_path / "five_bar.toml").write_text(mechanism.to_toml())
    status, told = run_json(capsys, "modes", tmp_path / "five_bar.toml")
    assert (status, told["given"]) == (0, {"x": 50.0, "y": 110.0})


def test_it_is_read_as_it_is_written():
    text = with_example(three_rps(), "{ z = 300.0, azimuth = 0.2, tilt = 0.1 }")
    assert parse(parse(text).to_toml()) == parse(text)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ("{ height = 3.0 }", "example.given.height"),
        ("{ z = nan }", "nan"),
        ("3.0", "example.given"),
        ('{ z = "a" }', "example.given.z"),
    ],
)
def test_mistakes_are_named(values, said):
    with pytest.raises(MechanismError, match=said):
        parse(with_example(three_rps(), values))


def test_it_stands_alone():
    with pytest.raises(MechanismError, match="exactly one of joints, pose and given"):
        parse(with_example(three_rps(), "{ z = 300.0 }") + "joints = [300.0, 300.0, 300.0]\n")
