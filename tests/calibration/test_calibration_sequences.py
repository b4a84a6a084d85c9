"""The Euler sequence of few postures: what does not close counts against a sequence, and what data
cannot tell is said.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers.gate import in_gate
from helpers.inside import (
    Noise,
    Trial,
    Workspace,
    find_sequence,
    fit_file,
    group_numbers,
    random_configurations,
    read_measurements,
    simulate_readings,
)
from helpers.measured_files import write_measurements
from symkin import InputError

NOMINAL = symkin.load("zhang2009")
NOISE = Noise(lengths=0.005, position=0.02, orientation=np.radians(0.002))


@pytest.fixture(scope="module")
def pool():
    """60 postures of a platform whose joint centres are off by up to 2 % of the size."""
    rng = np.random.default_rng(9)

    def away(point):
        return tuple(np.array(point) + 0.02 * NOMINAL.characteristic_length * rng.uniform(-1, 1, 3))

    true = replace(
        NOMINAL,
        limbs=[
            replace(limb, base=away(limb.base), platform=away(limb.platform))
            for limb in NOMINAL.limbs
        ],
    )
    made = random_configurations(Workspace.about(true), group_numbers(60, 0), NOISE, rng)
    return simulate_readings(NOMINAL, made, group_numbers(60, 0), ("pose",), NOISE, rng)


def hidden(path, measurements, sequence="XZX"):
    write_measurements(path, NOMINAL, measurements, sequence=sequence, hidden=True)
    return read_measurements(path, NOMINAL)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("count", [8, 9, 10, 12])
def test_few_postures_choose_the_sequence_that_explains_them_all(tmp_path, pool, count):
    """8 to 12 postures, three draws of each: the true sequence, clear of the runner-up, and a fit
    that uses every posture.
    """
    for k in range(3):
        rows = np.random.default_rng(100 * count + k).choice(60, count, replace=False)
        data = hidden(tmp_path / "data.csv", pool.subset(rows))
        choice = find_sequence(NOMINAL, data)
        assert "XZX" in (choice.sequence, *choice.same)
        assert choice.clear
        if k == 0:
            report = fit_file(NOMINAL, data)
            assert report.usable
            assert len(report.fit.used) == count


@pytest.mark.slow
@pytest.mark.parametrize("count", in_gate([6, 7], [6]))
def test_as_many_parameters_as_readings_tell_no_sequence(tmp_path, pool, count):
    """42 parameters and at most 42 readings: refused with the remedy, where any sequence would
    fit.
    """
    with pytest.raises(InputError, match="name the sequence in the header"):
        find_sequence(NOMINAL, hidden(tmp_path / "data.csv", pool.subset(np.arange(count))))


@pytest.mark.long
@pytest.mark.slow
def test_a_bad_row_does_not_change_the_sequence(tmp_path, pool):
    """A posture whose joints are off by 600 times their noise counts against every sequence
    alike.
    """
    joints = pool.joints.copy()
    joints[4] += [3.0, -3.0, 3.0, -3.0, 3.0, -3.0]
    data = hidden(tmp_path / "data.csv", replace(pool, joints=joints).subset(np.arange(20)))
    choice = find_sequence(NOMINAL, data)
    assert "XZX" in (choice.sequence, *choice.same)
    assert choice.clear


@pytest.mark.long
@pytest.mark.slow
def test_the_sequence_is_not_stated_where_nothing_fits(tmp_path, pool):
    """Exchanged columns: no sentence that the angles fit a sequence, in text and JSON."""
    report = fit_file(
        NOMINAL, hidden(tmp_path / "data.csv", replace(pool, position=pool.position[:, [1, 0, 2]]))
    )
    assert not report.usable
    assert "the angles fit" not in report.summary()
    assert "no Euler sequence led to a fit that can be used" in report.summary()
    assert report.to_dict()["euler_sequence"] is None


@pytest.mark.parametrize(
    ("best", "second", "clear"),
    [
        (Trial(30.0, 30, True), Trial(3e6, 30, True), True),
        (Trial(0.01, 2, True), Trial(2.5, 2, True), False),
        (Trial(30.0, 30, True), Trial(45.0, 30, True), False),
        (Trial(1e-9, 40, False), Trial(1e-3, 40, False), True),
        (Trial(1e-3, 1, False), Trial(1.0, 1, False), False),
    ],
)
def test_a_choice_is_clear_where_noise_cannot_make_the_difference(best, second, clear):
    """Known noise: the other must be worse than noise. Unknown noise: the readings must be less
    likely by the other, each with the noise that it leaves.
    """
    assert best.better_than(second) is clear
