"""Results of generated C may lie where inputs lie, as its header says: each on each, to the bit."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers.gate import in_gate
from helpers.inside import Options

ROOM = 64
"""Numbers of an argument, more than any has here."""
FOLDERS = {
    "rods": ("zhang2009", Options("float")),
    "arm": ("yao2020", Options("float")),
    "map": ("sarrus", Options("float", given=("foot_x",), find=("head_y",))),
}
Numbers = ctypes.c_float * ROOM


@pytest.mark.parametrize("key", in_gate(FOLDERS, ["rods", "map"]))
def test_results_may_lie_on_inputs(tmp_path, key):
    """At home, with each function's other numbers small."""
    name, options = FOLDERS[key]
    mechanism = symkin.load(name)
    asked, directions = (tools.bench_module(part) for part in ("asked", "directions"))
    code = asked.Asked(mechanism, options)
    home = directions.directions(code)[0].home
    sides = [np.ravel(values) for values in (home.known, home.guesses)]
    joints, other = sides[::-1] if mechanism.serial else sides
    values = {"joints": joints, "found": other, "pose": other}
    tools.write_code(mechanism, tmp_path, options)
    tools.built("gcc", tmp_path, [f"{name}.c"], "code.so", "-O2", "-shared", "-fPIC")
    library = ctypes.CDLL(str(tmp_path / "code.so"))
    differ, taken = [], 0
    for function in code.program.functions:
        call = getattr(library, f"{name}_{function.name}")
        call.joints = len(mechanism.actuated) if key != "map" else 1
        given = [_begun(value, values, sides[1]) for value in function.takes]
        begun = [_begun(value, values, sides[1]) for value in function.gives]
        for at, moved in enumerate(begun):
            for on, read in enumerate(given):
                if function.takes[on].count == "number":
                    continue
                # what begins where it is given reads the same numbers from both places
                start = read if function.moves else moved
                apart, aside = [
                    _called(call, function, given, [*begun[:at], start, *begun[at + 1 :]], pair)
                    for pair in (None, (at, on))
                ]
                taken += apart[0] == 0
                if apart[0] == 0 and apart != aside:
                    differ.append((function.name, function.gives[at].name, function.takes[on].name))
    assert taken > 5
    assert not differ


def _begun(value, values, guess):
    """Numbers of an argument, or a choice."""
    if value.count == "number":
        return 0
    numbers = guess if value.name == "guess" else values.get(value.name, [])
    return [*numbers, *[0.01] * (ROOM - len(numbers))]


def _called(call, function, given, begun, pair):
    """The status of a call and the results' numbers, the one of the pair on an input's room."""
    rooms = [v if isinstance(v, int) else Numbers(*v) for v in given]
    results = [Numbers(*v) for v in begun]
    if pair:
        results[pair[0]] = rooms[pair[1]]
    status = call(*[None] * function.config, *rooms, *results, *[None] * function.info)
    return status, [
        list(result)[: value.numbers(call.joints)]
        for value, result in zip(function.gives, results, strict=True)
    ]
