"""Arguments of generated C: results may lie where inputs lie, as the header says, and what is not
finite or beyond all bounds has the status of the contract, whatever argument holds it.
"""

from __future__ import annotations

from functools import cache
from math import inf, isfinite, nan
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

import symkin
from helpers import firmware_tools as tools
from helpers import joint_types, samples
from helpers.called_code import CalledCode
from helpers.gate import in_gate
from helpers.inside import Options, scaled
from helpers.wide_five_bar import wide_five_bar

OK, NONFINITE, OUT_OF_RANGE = 0, 3, 4
STRUCTS = {
    "struct of an arm": samples.pieper,
    "struct of limbs": samples.three_rrr,
    "struct of rods": joint_types.rods_at_the_end,
    "struct of a delta": lambda: symkin.load("delta"),
    "struct of a tiny arm": lambda: scaled(samples.pieper(), 1e-8),
    "struct of tiny limbs": lambda: scaled(samples.three_rrr(), 1e-8),
}
"""Machines whose code takes a struct of its geometry."""
FRESH = {
    "delta with rods": samples.delta,
    "three RPS": samples.three_rps,
    "five-bar": wide_five_bar,
    "rods at the end": joint_types.rods_at_the_end,
    "pieper": samples.pieper,
}
"""Kinds of machines that no folder has."""
FEW = [*tools.COMMITTED, "zhang2009_double_struct", "struct of an arm"]
"""What the gate asks: the committed folders, and structs of rods and joints."""
KEYS = [*tools.FOLDERS, *STRUCTS, *FRESH]
EVERY = in_gate(KEYS, FEW)
NEAR = (1, 3, 5)
"""Vectors whose guesses are near, from which single steps go too."""
ANY = {"rate_limits", "joint_limits", "joint_inertias"}
"""What may be of any size from 0 on."""


@pytest.fixture(autouse=True)
def nothing_undefined(capfd):
    """No call divides, shifts, reads beyond an array or casts as C does not define."""
    yield
    assert "runtime error" not in capfd.readouterr().err


@cache
def code_of(key: str) -> CalledCode:
    """The code of a folder, or of a machine of STRUCTS or FRESH in float."""
    tools.compiler("gcc")
    with TemporaryDirectory() as place:
        folder = Path(place) / "folder"
        if key in tools.FOLDERS:
            return CalledCode(tools.folder(key), Path(place))
        made = (STRUCTS | FRESH)[key]()
        options = Options("float", geometry="struct" if key in STRUCTS else "fixed")
        tools.write_untested(made, folder, options)
        return CalledCode(folder, Path(place))


@pytest.mark.slow
@pytest.mark.parametrize("key", in_gate(KEYS, [*FEW, "three RPS"]))
def test_results_may_lie_on_inputs(key):
    """Each result on each input, at several configurations, to the bit."""
    code, differ, taken = code_of(key), [], set()
    for function in code.functions:
        inputs = [value.name for value in function.takes] + ["geometry"] * bool(code.geometry)
        pairs = [(r, a) for r in range(len(function.gives)) for a in range(len(inputs))]
        for k in NEAR:
            given = code.given(function, k)
            for r, a in pairs:
                place = given[a] if a < len(given) else code.geometry
                if not place:
                    continue
                begun, read = code.begun(function, k), [*given]
                if function.moves:
                    # what begins where it is given reads the same numbers from both places
                    begun[r] = [*place, *begun[r][len(place) :]]
                    read[a : a + 1] = [begun[r]] * (a < len(given))
                apart, aside = (code.call(function, read, begun, on) for on in (None, (r, a)))
                taken |= {function.name} if apart.status == OK else set()
                if aside.status != apart.status or (apart.status == OK and aside != apart):
                    differ.append((function.name, function.gives[r].name, inputs[a], k))
    assert not differ
    # one branch of an arm may have no joints at any of these poses
    assert {f.name for f in code.functions if f.gives and not f.moves} - taken <= {"inverse_branch"}


def spoilt(code, function, k):
    """Each number that a function reads: its argument, and which one of which it is."""
    given, begun = code.given(function, k), code.begun(function, k)
    places = [
        (function.takes[i].name, i, j) for i, one in enumerate(given) for j in range(len(one))
    ]
    places += [("begun", 0, j) for j in range(len(begun[0]))] if function.moves else []
    return places + [("geometry", 0, j) for j in range(len(code.geometry))]


def said(code, function, k, place, value, *, wrong=False):
    """What a call says with a value at a place, all other numbers good or `wrong`, and whether its
    results are as before.
    """
    name, i, j = place
    given, begun, geometry = code.given(function, k), code.begun(function, k), [*code.geometry]
    if wrong:
        given = [[9e9] * len(numbers) for numbers in given]
    {"begun": begun, "geometry": [geometry]}.get(name, given)[i][j] = value
    told = code.call(function, given, begun, geometry=geometry)
    return told, told.bits == code.bits(begun)


def is_whole(told, *, untouched):
    """Whether a call left what its status promises: finite results of OK, else untouched ones, and
    an info that it wrote.
    """
    numbers = [number for result in told.results for number in result]
    return all(map(isfinite, numbers)) if told.status == OK else untouched


def is_written(function, told):
    """Whether an info was written, without what is no number."""
    own = [told.info[name] for name in ("residual", "step", "min_pivot")]
    return not function.info or all(number >= 0.0 for number in own)


@pytest.mark.slow
@pytest.mark.parametrize("key", EVERY)
def test_what_is_not_finite_is_told_so_in_every_argument(key):
    """NONFINITE, among good numbers and among wrong ones; results stay, info is written."""
    code, faults = code_of(key), []
    for function in code.functions:
        for place in spoilt(code, function, 1):
            for value in (nan, inf, -inf):
                for wrong in (False, True):
                    told, untouched = said(code, function, 1, place, value, wrong=wrong)
                    if (
                        told.status != NONFINITE
                        or not is_whole(told, untouched=untouched)
                        or not is_written(function, told)
                    ):
                        faults.append((function.name, place, value, wrong, told.status))
    assert not faults


LISTED = ["ur5e_double", "gluon_6l3_double", "yao2020_float"]


@pytest.mark.slow
@pytest.mark.parametrize("key", LISTED)
def test_all_branches_of_what_is_no_pose_are_none(key):
    """Of a pose that is not finite, or beyond all bounds, no branch is listed; of a good one all
    that are listed are finite.
    """
    code = code_of(key)
    for function in code.listing:
        for place in spoilt(code, function, 1):
            for value in (nan, inf, -inf, 1e20, 3e38 if code.is_float else 1e308):
                told, untouched = said(code, function, 1, place, value)
                assert (told.status, untouched) == (0, True)
        good = [code.call(function, code.given(function, k), code.begun(function, k)) for k in NEAR]
        assert all(map(isfinite, good[0].results[0]))
        assert any(told.status > 0 for told in good)


@pytest.mark.slow
@pytest.mark.parametrize("key", EVERY)
def test_what_is_beyond_all_bounds_is_out_of_range_in_every_argument(key):
    """The largest numbers and those whose squares overflow: OUT_OF_RANGE, but limits and rates that
    leave results finite.
    """
    code, faults = code_of(key), []
    for function in code.functions:
        for place in spoilt(code, function, 1):
            for size in (3e38, 1e20) if code.is_float else (1e308, 1e160):
                for value in (size, -size):
                    told, untouched = said(code, function, 1, place, value)
                    bounded = place[0] not in ANY and not (code.kind == "map" and _rate(place[0]))
                    if (
                        (told.status not in (OK, OUT_OF_RANGE))
                        or (told.status == OK and bounded)
                        or not is_whole(told, untouched=untouched)
                        or not is_written(function, told)
                    ):
                        faults.append((function.name, place, value, told.status))
    assert not faults


def _rate(name):
    return name in ("joint_rates", "found_torques")


@pytest.mark.slow
@pytest.mark.parametrize("key", EVERY)
def test_zeros_of_either_sign_and_the_least_numbers_are_one(key):
    """-0 and numbers below the least normal one have the status of 0, and answers next to its: of
    the choice nearest to a guess, which may be that of either side, only the status.
    """
    code, faults = code_of(key), []
    for function in code.functions:
        for place in spoilt(code, function, 1):
            zero, _ = said(code, function, 1, place, 0.0)
            least = 1e-45 if code.is_float else 5e-324
            for value in (-0.0, least, *([-least] if place[0] not in ANY else [])):
                told, untouched = said(code, function, 1, place, value)
                whole = is_whole(told, untouched=untouched) and is_written(function, told)
                chosen = function.name == "inverse_nearest"
                if not whole or (not chosen and not _same(told, zero)):
                    faults.append((function.name, place, value, told.status, zero.status))
    assert not faults


def _same(told, other):
    pairs = [
        (a, b)
        for one, two in zip(told.results, other.results, strict=True)
        for a, b in zip(one, two, strict=True)
    ]
    size = max([abs(b) for _, b in pairs] + [1e-9])
    return told.status == other.status and all(abs(a - b) <= 1e-5 * size for a, b in pairs)
