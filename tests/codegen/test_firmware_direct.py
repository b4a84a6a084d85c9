"""C of direct problems that formulas solve: lines beside folds, far lines, and what is said of
them.
"""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers import samples
from helpers.gate import in_gate
from helpers.inside import LimbPlatform, Options, build_program
from helpers.samples import delta_directions
from symkin import Joint, Limb, Mechanism, Rod

FIVE_BAR = str(Path(__file__).parents[2] / "codegen" / "bench" / "machines" / "five_bar.toml")


def linear_delta() -> Mechanism:
    """Three upright slides on a circle of 150, rods of 250 to a platform's circle of 40."""
    limbs = []
    for k in range(3):
        outward, tangent = delta_directions(k)
        rods = [
            Rod(tuple(150 * outward + s * tangent), tuple(40 * outward + s * tangent))
            for s in (-25, 25)
        ]
        limbs.append(
            Limb(
                f"limb{k}",
                [Joint(f"q{k}", "P", tuple(150 * outward), (0.0, 0.0, 1.0), actuated=True)],
                rods,
            )
        )
    depth = -math.sqrt(250.0**2 - 110.0**2)
    return Mechanism(
        "linear_delta", limbs, platform_position=(0.0, 0.0, depth), motion="translation"
    )


MACHINES = {
    "delta": lambda: symkin.load("delta"),
    "linear delta": linear_delta,
    "five-bar": lambda: symkin.load(FIVE_BAR),
    "3-TRT + SPS": lambda: symkin.load("zhao2000"),
}


@pytest.mark.slow
@pytest.mark.parametrize("real", in_gate(["double", "float"], ["float"]))
@pytest.mark.parametrize("name", in_gate(MACHINES, ["delta"]))
def test_lines_from_all_over_the_workspace(name, real):
    """From home, from answers and from guesses beside the folds at which lines stopped: what is OK
    is what a fine walk reaches, and nearly all regular lines are.
    """
    tools.compiler("gcc")
    asked = tools.bench_module("asked")
    reach = tools.bench_module("ranges").Reach(0.3, 1.5)
    found = tools.study(asked.Asked(MACHINES[name](), Options(real)), 300, reach, seed=5, legs=2)
    assert not found.said
    assert found.regular.sum() > 100
    assert found.ok_of_regular > 96.0


@pytest.mark.parametrize("name", in_gate(MACHINES, ["3-TRT + SPS", "delta"]))
def test_formulas_are_found(name):
    """And nothing of Newton's method is left in the direct problem."""
    program = build_program(MACHINES[name](), Options("double"))
    assert isinstance(program.kind, LimbPlatform)
    assert program.kind.direct_formulas is not None
    assert "_direct_newton(" not in program.source
    assert "atan2" not in program.source.split("_direct_reach(", 1)[1].split("_track(", 1)[0]


def test_machines_without_formulas_keep_the_iteration():
    """Limbs that no formulas solve, and a geometry that is told at run time."""
    program = build_program(samples.three_rps(), Options("double"))
    assert program.kind.direct_formulas is None
    program = build_program(symkin.load("delta"), Options("double", geometry="struct"))
    assert program.kind.direct_formulas is None
    assert "_direct_newton(" in program.source


def test_the_readme_derives_the_formulas():
    text = (tools.folder("delta_double") / "README.md").read_text()
    assert "## Direct problem in closed form" in text
    assert "cut by the quadratic one: two values" in text
    assert "Newton's method finds" not in text


def test_guards_are_positive_where_the_machine_works():
    """At sampled configurations of the workspace each guard is above zero, and below its bound."""
    program = build_program(symkin.load("zhao2000"), Options("double"))
    kind = program.kind
    found = kind.direct_formulas
    form = found.form
    squares = ca.vertcat(*(one.value for one in form.discriminants))
    for sample in kind.samples[:10]:
        (discriminants,) = form.at(squares, form.signs_at(sample.values), sample.known[None])
        assert discriminants.size
        assert np.all(discriminants > 0.0)
        assert discriminants[0] < found.guards[0].bounds[-1].size


@pytest.mark.parametrize(
    ("kind", "real"), in_gate(product(["R", "P"], ["float", "double"]), [("R", "float")])
)
def test_formulas_that_nothing_can_stop_compile_without_a_warning(kind, real, tmp_path):
    """One limb whose joints are all actuated: its pose has formulas that divide by nothing, take no
    root and have no guard.
    """
    tools.compiler("gcc")
    first = Joint("a", kind, (100.0, 50.0, 0.0), (0.0, 0.0, 1.0), actuated=True)
    second = Joint("b", "R", (100.0, -50.0, 0.0), (0.0, 0.0, 1.0), actuated=True)
    limb = Limb("limb", [first, second])
    made = Mechanism("arm", [limb], platform_position=(-100.0, -100.0, 0.0), motion="schoenflies")
    found = build_program(made, Options(real)).kind.direct_formulas
    assert found is not None
    assert not found.guards
    symkin.write_firmware(made, tmp_path, real=real)
    # GCC 12.2 at -O2 loses stores to an array into which a function has written by two loops
    for optimised in ("-O1", "-O2"):
        tools.passed(tools.built("gcc", tmp_path, ["arm.c", "arm_test.c"], "own", optimised))
