"""The short form of `tests/campaigns/random_mechanisms.py`, and the laws of the closure and the
search that it judges by.
"""

import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import symkin
from campaigns.random_files import random_file, to_toml
from oracle.plain_closure import PlainMechanism

CAMPAIGN = Path(__file__).resolve().parents[1] / "campaigns" / "random_mechanisms.py"
SEED, QUICK = 4, (5, 7, 10, 12, 14, 17, 22, 23, 25, 26, 27, 31, 33, 36, 42, 44, 47, 49)
"""Mechanisms that take less than three seconds each, all families among them."""


@pytest.mark.long
@pytest.mark.slow
def test_random_mechanisms_pass_through_every_verb(tmp_path):
    """No traceback, no mode lost, nothing that does not close, in a process for each mechanism."""
    only = [str(i) for i in QUICK]
    command = [
        sys.executable,
        str(CAMPAIGN),
        "--seed",
        str(SEED),
        "--workers",
        "2",
        "-o",
        str(tmp_path),
        "--only",
        *only,
    ]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert (
        f"{len(QUICK)} mechanisms: 0 tracebacks, 0 lost modes, 0 wrong answers, 0 timeouts, 0 "
        f"crashes" in run.stdout
    )


@pytest.mark.slow
@pytest.mark.parametrize("index", range(8))
def test_the_judging_closure_has_the_derivatives_that_it_states(index):
    """Central differences of the rows along every tangent, at a configuration far from closed."""
    rng = np.random.default_rng([7, index])
    m = PlainMechanism(random_file(rng))
    x = m.move(m.reference[None], 0.3 * m.size * rng.normal(size=(1, m.freedom)))
    h = 1e-5 * m.size
    ahead, behind = (
        m.closure(m.move(np.tile(x, (m.freedom, 1)), s * h * np.eye(m.freedom)))[0] for s in (1, -1)
    )
    assert np.allclose((ahead - behind).T / (2 * h), m.closure(x)[1][0], atol=1e-7)
    assert m.residual(m.reference[None])[0] < 1e-12


def test_the_judging_closure_and_symkin_agree_on_shipped_mechanisms():
    """What symkin solves, the plain closure of the file finds closed."""
    for name in ("zhao2000_links", "gluon_6l3", "yao2020"):
        mechanism = symkin.load(name)
        m = PlainMechanism(tomllib.loads(mechanism.to_toml()))
        assert np.isclose(m.size, mechanism.characteristic_length)
        assert m.residual(m.reference[None])[0] < 1e-9


def test_files_are_the_same_for_the_same_seed():
    """Two draws of one seed are one text, and one mechanism of symkin's."""
    first, second = (to_toml(random_file(np.random.default_rng([4, 9]))) for _ in range(2))
    assert first == second
