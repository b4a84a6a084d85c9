"""Maps of random machines and of loops that are given by their inner joints: groups that stand on
groups, hard stretches of a line, any size, standing still.
"""

import ctypes
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.documents import machines
from helpers.gate import in_gate
from helpers.inside import (
    SLIDE_PARTS,
    ClosedDirection,
    JointMap,
    Options,
    Real,
    can_run,
    displaced,
    folder_files,
    free_divisors,
    map_configurations,
    parse,
    run_own_test,
    scaled,
    share_of,
    write_folder,
)

MAPS = Path(__file__).parents[1] / "data" / "maps"
CASES = {
    "seven_bar_loop": (("j5.1",), ("j4.1",)),
    "nested_dyads": (("j11",), ("j16",)),
    "nested_slides": (("j6", "j5"), ("j15", "j4")),
    "beside_two_folds": (("j15",), ("j3",)),
}
INNER = (
    ("five_bar", "right,left", "pin,elbow2"),
    ("five_bar", "pin,elbow1", "left,right"),
    ("pantograph_leg", "horizontal,slider_pin", "vertical,thigh_pin"),
)
"""Maps whose given values are of joints inside: angles are taken out of rows with a matrix that
these turn, and a condition bends far more with one of them than with another.
"""
SLIDES = ("pantograph_leg", "vertical,horizontal", "thigh_pin,knee")
"""A map of slides without limits, whose conditions bend by hundreds of times more a size away."""
BESIDE_A_FOLD = ("jansen_leg", "upper_crank_pin", "knee")
"""A map whose inverse, by Newton's method, has a fold a tenth of a radian from the reference."""
OBLIQUE = ("leg", "motor,m1,m2", "knee,au.1,au.2")
"""A four-bar in an oblique plane that carries an ankle on two rods: two of three oblique rows cost
float its digits.
"""
GEARED = "geared_five_bar", Options("float", given=("left",), find=("le",))
"""A five-bar whose cranks are geared 2 to -1, and a map that Newton's method solves backwards."""


def _inner(name, given, find, factor=1.0):
    made = (
        parse(machines("README.md")["five_bar.toml"], "five_bar.toml")
        if name == "five_bar"
        else symkin.load(MAPS / "leg.toml" if name == "leg" else name)
    )
    options = Options("double", given=tuple(given.split(",")), find=tuple(find.split(",")))
    made = made if factor == 1.0 else scaled(made, factor)
    return JointMap(made, options, Real("double", f"{name}_real"))


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


def _bends(closed):
    """Bounds of second derivatives along lines, known values in sizes and radians."""
    known = closed.direction.known
    scales = np.array([1.0 if c.is_angular else closed.made.size for c in known])
    return np.array([2 * guard.bounds[-1].plain * scales**2 for guard in closed.guards])


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
        [("seven_bar_loop", "double")],
    ),
)
def test_code_of_random_maps_passes_its_own_test(library, name, real):
    """Configurations near the reference that are regular to the type's digits are reached, and
    stood at, both ways.
    """
    assert library(name, real)


@pytest.mark.skipif(not can_run(), reason="no C compiler")
@pytest.mark.parametrize(
    ("name", "given", "find"),
    in_gate((*INNER, BESIDE_A_FOLD, SLIDES, OBLIQUE), (BESIDE_A_FOLD, SLIDES, OBLIQUE)),
)
def test_maps_of_inner_joints_pass_their_own_test(name, given, find):
    """The reference is regular both ways: its surroundings are reached and left in float too,
    beside a fold too, where steps of rounding come near to the way to it.
    """
    made = _inner(name, given, find)
    options = Options("float", given=made.options.given, find=made.options.find)
    run_own_test(made.name, folder_files(made.mechanism, options))


@pytest.mark.parametrize(
    ("inner", "factor"),
    in_gate(product(INNER, [1e-8, 1e6]), [(INNER[0], 1e-8), (INNER[1], 1e6)]),
)
def test_conditions_of_inner_joints_bend_alike_at_any_size(inner, factor):
    """No condition has its bend from where something vanishes that it is divided by; usual sizes
    are numbers of a float.
    """
    plain, other = _inner(*inner), _inner(*inner, factor)
    for one, same in ((plain.direct, other.direct), (plain.inverse, other.inverse)):
        here, there = ClosedDirection(plain, one, {}), ClosedDirection(other, same, {})
        assert np.max(_bends(here)) < 8e4
        assert np.allclose(_bends(here), _bends(there), rtol=0.1)
        assert np.all(np.abs(np.log10(np.abs(there.usual))) < 37)


@pytest.mark.parametrize(
    ("name", "reach"),
    in_gate(
        [("nested_dyads", 1.0), ("nested_slides", 1.0), ("pantograph_leg", 0.05), ("slides", 0.05)],
        [("pantograph_leg", 0.05), ("slides", 0.05)],
    ),
)
def test_conditions_stay_above_their_bound_along_lines(name, reach):
    """Of a condition that reads others: on lines on which these keep shares, it is no less than its
    chord's lesser end less the bound, that of the part of the slides' ranges that holds the line.
    Lines reach so many sizes, and radians, from the reference.
    """
    inner = [_inner(*one) for one in INNER if one[0] == name]
    if name == "slides":
        made, rng, tried = _inner(*SLIDES), np.random.default_rng(3), 0
    else:
        made, rng, tried = (inner or [_plain(name)])[0], np.random.default_rng(3), 0
    direction = ClosedDirection(made, made.inverse if inner else made.direct, {})
    coordinates = direction.direction.known
    values = direction.formulas.values
    plain = [
        direction._put_in(one.value) * guard.factor
        for one, guard in zip(direction.conditions, direction.guards, strict=True)
    ]
    shares = [
        share_of(v, divides=c.root is None)
        for v, c in zip(plain, direction.conditions, strict=True)
    ]
    function = ca.Function("f", [values], [ca.vertcat(*plain), ca.vertcat(*shares)])
    scales = np.array([1.0 if c.is_angular else made.size for c in coordinates])
    for _ in range(1000):
        begin = (
            made.reference_of(coordinates) + reach * rng.uniform(-1.0, 1.0, len(scales)) * scales
        )
        end = (
            begin
            + reach * 10.0 ** rng.uniform(-2.0, 0.0) * rng.uniform(-1.0, 1.0, len(scales)) * scales
        )
        line = np.linspace(begin, end, 33)
        conditions, kept = (np.asarray(part).T for part in function(line.T))
        away = np.abs([begin, end] - made.reference_of(coordinates)) / scales
        slides = [k for k, c in enumerate(coordinates) if not c.is_angular]
        beyond = [np.max(away[:, slides], initial=0.0) > part for part in SLIDE_PARTS[:-1]]
        for j, guard in enumerate(direction.guards):
            read = [*guard.read, *([] if guard.root is None else [guard.root])]
            if not np.all(conditions[:, read] > 0.0):
                continue
            bound = guard.bounds[min(sum(beyond), len(guard.bounds) - 1)]
            share = float(np.prod(kept[:, list(guard.read)].min(axis=0)))
            bend = (end - begin) ** 2 @ bound.plain / max(share, 1e-12)
            if guard.root is not None:
                least = max(conditions[:, guard.root].min(), 1e-12)
                bend += (end - begin) ** 2 @ (bound.by_root + bound.by_cube / least) / least**0.5
            low = min(conditions[0, j], conditions[-1, j]) - 0.25 * bend
            assert conditions[:, j].min() >= low - 1e-9
            tried += len(read) > 0 or name == "slides"
    assert tried > 500


@pytest.mark.parametrize("name", in_gate(["nested_dyads", "nested_slides"], ["nested_dyads"]))
def test_bends_of_nested_conditions_let_lines_pass(name):
    """With shares put in, bends are those of the machine, not of the fold that samples come nearest
    to.
    """
    assert np.max(_bends(_closed(name, "direct"))) < 8e4


@pytest.mark.parametrize(
    ("name", "factor"),
    in_gate(product(["nested_dyads", "nested_slides"], [1e-8, 1e6]), [("nested_dyads", 1e-8)]),
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
            assert np.allclose(_bends(here), _bends(there), rtol=0.1)


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


@pytest.mark.parametrize("factor", in_gate([1e-8, 1e-3, 1e6], [1e-8]))
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


def test_sampled_configurations_are_where_fine_steps_lead():
    """Configurations that vectors and bounds are made of are reached from the reference in twenty
    times as many steps too: none was found by a leap over a fold.
    """
    made = _plain("beside_two_folds")
    found = map_configurations(made, 24, 20, 0.06, 0.3)
    assert len(found) > 3
    system = made.direct.problem.system
    start, begin = made.reference_of(made.given), made.reference_of(made.direct.unknown)
    for case in found:
        z = begin
        for part in np.linspace(0.0, 1.0, 241)[1:]:
            z = system.polish(z, start + part * (case.known - start), 3)
        np.testing.assert_allclose(z, case.unknown, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("limited", ["left", "re"])
def test_an_answer_at_a_limit_is_held(limited):
    """An answer just within the limits of a found joint, or of a passive one, is OK from itself,
    though a step of rounding leads over the limit.
    """
    tools.compiler("gcc")
    (name, options), oblique = GEARED, symkin.Pose.from_euler([0, 0, 0], [0.83, -0.41, 1.9])
    machine = symkin.load(MAPS / f"{name}.toml")
    low, high = np.radians({"left": (30.0, 190.0), "re": (-100.0, 100.0)}[limited])
    limits = {"left": None, "re": None, limited: (low, high)}
    links = [
        replace(link, joint=replace(link.joint, limits=limits.get(link.joint.name)))
        for link in machine.link_joints
    ]
    machine = displaced(replace(machine, link_joints=links), oblique)
    asked = tools.bench_module("asked").Asked(machine, options)
    lines = tools.bench_module("directions").directions(asked)[1]
    row = tools.bench_module("grazes").grazed(lines, 30, np.random.default_rng(5))
    assert row.ok > 200
    assert row.said == []


@pytest.mark.slow
def test_newton_takes_parts_as_long_as_steps_let_expect():
    """A loop whose matrix grows tenfold on the way: paths along which nothing is singular are
    followed both ways where answers tell where the loop stands, and nothing else is OK.
    """
    tools.compiler("gcc")
    asked, ranges = tools.bench_module("asked"), tools.bench_module("ranges")
    given, find = CASES["seven_bar_loop"]
    machine = symkin.load(MAPS / "seven_bar_loop.toml")
    loop = asked.Asked(machine, Options("double", given=given, find=find))
    for lines in tools.bench_module("directions").directions(loop):
        goals = ranges.paths(lines, 8, np.random.default_rng(0), 60)
        found = tools.bench_module("rows").judged(lines, goals)
        assert found.said == []
        assert found.ok > 200
        assert found.ok_of_regular > 90.0
