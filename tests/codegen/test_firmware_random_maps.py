"""Maps of random machines: groups that stand on groups, hard stretches of a line, any size,
standing still.
"""

import ctypes
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.gate import each_once, in_gate
from helpers.inside import (
    ClosedDirection,
    JointMap,
    Options,
    Real,
    free_divisors,
    share_of,
    write_folder,
)
from helpers.moved_mechanisms import scaled

MAPS = Path(__file__).parents[1] / "data" / "maps"
CASES = {
    "seven_bar_loop": (("j5.1",), ("j4.1",)),
    "nested_dyads": (("j11",), ("j16",)),
    "nested_slides": (("j6", "j5"), ("j15", "j4")),
}


def _map(name, real="double", mechanism=None):
    given, find = CASES[name]
    made = mechanism or symkin.load(MAPS / f"{name}.toml")
    return JointMap(made, Options(real, given=given, find=find), Real(real, f"{name}_real"))


@cache
def _plain(name):
    """The map of the machine as its file has it, once for all tests here."""
    return _map(name)


@cache
def _closed(name, way):
    """Conditions of one direction of this map, which is closed."""
    made = _plain(name)
    return ClosedDirection(made, getattr(made, way), {})


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """A map's compiled code, whose own test has passed: else `write_folder` raises."""
    tools.compiler("gcc")

    @cache
    def built(name, real):
        folder, (given, find) = tmp_path_factory.mktemp("code"), CASES[name]
        write_folder(
            symkin.load(MAPS / f"{name}.toml"), folder, Options(real, given=given, find=find)
        )
        tools.built("gcc", folder, [f"{name}.c"], "code.so", "-O1", "-shared", "-fPIC")
        return ctypes.CDLL(str(folder / "code.so"))

    return built


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "real"),
    in_gate(
        [(name, real) for name in CASES for real in ("float", "double")],
        [("seven_bar_loop", "double"), ("nested_dyads", "float")],
    ),
)
def test_code_of_random_maps_passes_its_own_test(library, name, real):
    """Configurations near the reference that are regular to the type's digits are reached, and
    stood at, both ways.
    """
    assert library(name, real)


@pytest.mark.parametrize("name", in_gate(["nested_dyads", "nested_slides"], ["nested_slides"]))
def test_conditions_stay_above_their_bound_along_lines(name):
    """Of a condition that reads others: on lines on which these keep shares, it is no less than its
    chord's lesser end less the bound.
    """
    made, rng, tried = _plain(name), np.random.default_rng(3), 0
    direction = _closed(name, "direct")
    values = ca.SX.sym("v", len(made.given))
    plain = [
        direction._put_in(one.value, values) / usual
        for one, usual in zip(direction.conditions, direction.usual, strict=True)
    ]
    shares = [
        share_of(v, divides=c.root is None)
        for v, c in zip(plain, direction.conditions, strict=True)
    ]
    function = ca.Function("f", [values], [ca.vertcat(*plain), ca.vertcat(*shares)])
    scales = np.array([1.0 if c.is_angular else made.size for c in made.given])
    for _ in range(1000):
        begin = made.reference_of(made.given) + rng.uniform(-1.0, 1.0, len(scales)) * scales
        end = begin + 10.0 ** rng.uniform(-2.0, 0.0) * rng.uniform(-1.0, 1.0, len(scales)) * scales
        line = np.linspace(begin, end, 33)
        conditions, kept = (np.asarray(part).T for part in function(line.T))
        way2 = float(np.sum(((end - begin) / scales) ** 2))
        for j, bend in enumerate(direction._bends):
            if not np.all(conditions[:, list(bend.read)] > 0.0):
                continue
            share = float(np.prod(kept[:, list(bend.read)].min(axis=0)))
            low = min(conditions[0, j], conditions[-1, j]) - bend.eighth * way2 / max(share, 1e-12)
            assert conditions[:, j].min() >= low - 1e-9
            tried += len(bend.read) > 0
    assert tried > 500


def test_bends_of_nested_conditions_let_lines_pass():
    """With shares put in, bends are those of the machine, not of the fold that samples come nearest
    to.
    """
    for name in ("nested_dyads", "nested_slides"):
        assert max(_closed(name, "direct").bends) < 1e4


@pytest.mark.parametrize(
    ("name", "factor"), each_once(["nested_dyads", "nested_slides"], [1e-8, 1e6])
)
def test_conditions_are_those_of_any_size(name, factor):
    """The same conditions with the same bends, over their usual sizes, of a machine in any unit."""
    plain = _plain(name)
    other = _map(name, mechanism=scaled(plain.mechanism, factor))
    for way in ("direct", "inverse"):
        one, same = getattr(plain, way), getattr(other, way)
        assert one.is_closed == same.is_closed
        if one.is_closed:
            here, there = _closed(name, way), ClosedDirection(other, same, {})
            assert [c.name for c in here.conditions] == [c.name for c in there.conditions]
            assert np.allclose(here.bends, there.bends, rtol=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("way", ["direct", "inverse"])
def test_who_is_where_a_line_led_may_stand_still(library, way):
    """What is reached from the reference is taken once more from itself, though the wanted values
    alone do not lead back there.
    """
    code, number = library("seven_bar_loop", "double"), ctypes.c_double * 1
    solve, taken = getattr(code, f"seven_bar_loop_{way}"), 0
    for goal in np.linspace(-1.0, 1.0, 401):
        answer = number(0.0)
        if solve(None, number(goal), answer, answer, None) == 0:
            first, taken = answer[0], taken + 1
            assert solve(None, number(goal), answer, answer, None) == 0
            assert abs(answer[0] - first) < 1e-9
    assert taken > 20


@pytest.mark.parametrize("factor", [1e-8, 1e-3, 1e6])
def test_guards_of_divisors_are_those_of_any_size(factor):
    """Cylinders stand between lengths and angles, whose discriminants have other units than what is
    divided by.
    """
    given, find = (
        ("boom_cylinder", "stick_cylinder", "bucket_cylinder"),
        ("boom", "stick", "bucket"),
    )
    sets = []
    for size in (1.0, factor):
        mechanism = scaled(symkin.load("excavator_bucket"), size)
        made = JointMap(
            mechanism, Options("double", given=given, find=find), Real("double", "x_real")
        )
        parts = [part for way in (made.direct, made.inverse) for part in way.parts]
        sets.append([None if part.form is None else free_divisors(part.form) for part in parts])
    assert sets[0] == sets[1]
