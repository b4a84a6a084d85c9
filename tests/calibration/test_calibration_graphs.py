"""Calibration of graphs of links: passive encoders, named points, distances, other links' poses."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import symkin
from helpers import linkages
from helpers.gate import in_gate, in_gate_but
from helpers.inside import (
    OUTLIER_LEVEL,
    Noise,
    Workspace,
    build_model,
    default_parameters,
    geometry_parameters,
    group_numbers,
    identifiability,
    measurements_text,
    observables,
    parameter_names,
    parse,
    random_configurations,
    read_measurements,
    reference_motions,
    simulate_readings,
    solve_configurations,
    with_parameters,
)
from symkin import InputError, Joint, calibrate

ANGLE, LENGTH = 2e-5, 0.01
"""Noise of encoders (radians) and of positions (mm)."""
RICH = {
    "four_bar": [
        "follower",
        "follower_pin",
        "coupler.position",
        "coupler.orientation",
        "rocker.inclination",
    ],
    "stephenson_six_bar": ["output", "rocker", "point.coupler_point"],
    "ankle": ["pose", "ankle.1", "point.toe", "distance.toe.heel"],
    "double_wishbone": ["pose", "upper_hinge", "point.contact"],
    "parallel_gripper": ["pose"],
    "excavator_bucket": ["pose"],
    "zhao2000": ["pose", "radial1"],
}
"""Readings of graphs, and of limbs with an encoder on a passive joint."""


def taken(mechanism, readings, count=30, seed=0, noise=None):
    """Readings as symkin simulates them, and the configurations."""
    rng = np.random.default_rng(seed)
    noise = noise or Noise(0.0, 0.0)
    made = random_configurations(Workspace.about(mechanism), group_numbers(count, 0), noise, rng)
    return simulate_readings(mechanism, made, group_numbers(count, 0), readings, noise, rng), made


def read_of_four_bar(points, rng, *, pen=True, count=60, offset=0.0, noise=1.0):
    """What encoders, and a tracker, read of a four-bar that turns fully."""
    crank = rng.uniform(-np.pi, np.pi, count)
    follower, places, _, _ = linkages.readings(points, crank, offset)
    readings = [symkin.Reading("follower", follower + noise * rng.normal(0, ANGLE, count), ANGLE)]
    if pen:
        whole = np.column_stack(
            [
                places + noise * rng.normal(0, LENGTH, places.shape),
                noise * rng.normal(0, LENGTH, count),
            ]
        )
        readings.append(symkin.Reading("point.pen", whole, LENGTH))
    return symkin.Measurements(crank[:, None], readings=readings)


# --- what is read ---------------------------------------------------------------------------------


def test_a_four_bar_reads_what_circles_say():
    """Follower, pen, distance and turn of the coupler at the cranks of a full turn, by circles."""
    four_bar, crank = parse(linkages.toml()), np.linspace(-3.0, 3.0, 9)
    follower, pen, distance, turn = linkages.readings(linkages.POINTS, crank)
    data = symkin.Measurements(
        crank[:, None],
        readings=[
            symkin.Reading("follower", follower),
            symkin.Reading("point.pen", np.column_stack([pen, 0.0 * crank])),
            symkin.Reading("distance.pen.mark", distance),
            symkin.Reading(
                "coupler.orientation",
                np.column_stack([np.cos(turn / 2), 0 * turn, 0 * turn, np.sin(turn / 2)]),
            ),
        ],
    )
    model = build_model(four_bar, data, ())
    found = solve_configurations(model, data, np.zeros(0))
    assert found.solved.all()
    h = model.evaluate(found.z, data.joints, np.zeros(0), data.quaternions).readings
    assert model.columns[0] == ("follower", "angle")
    np.testing.assert_allclose(h[:, 0], follower, atol=1e-9)
    np.testing.assert_allclose(h[:, 1:3], pen, atol=1e-7)
    np.testing.assert_allclose(h[:, 4], distance, atol=1e-7)
    np.testing.assert_allclose(h[:, 5:], 0.0, atol=1e-9)


@pytest.mark.parametrize(
    "name", in_gate(RICH, ["ankle", "four_bar", "parallel_gripper", "zhao2000"])
)
def test_readings_of_the_model_are_those_simulated(name):
    """The model's expressions over joints and unknowns agree with the poses of links at the same
    configurations.
    """
    mechanism = symkin.load(name)
    data, _ = taken(mechanism, RICH[name])
    model = build_model(mechanism, data, ())
    found = solve_configurations(model, data, np.zeros(0))
    assert found.solved.all()
    h = model.evaluate(found.z, data.joints, np.zeros(0), data.quaternions).readings
    observed = [o for o in model.channels if o.of]
    for o, reading in zip(observed, data.readings, strict=True):
        columns = [k for k, (kind, _) in enumerate(model.columns) if kind == o.name]
        wanted = np.zeros((len(data), 3)) if o.kind == "orientation" else reading.values
        np.testing.assert_allclose(
            h[:, columns], wanted, atol=1e-8 * mechanism.characteristic_length
        )


@pytest.mark.parametrize(
    "name",
    in_gate_but(
        RICH,
        ["stephenson_six_bar", "double_wishbone", "excavator_bucket", "ankle", "parallel_gripper"],
    ),
)
def test_slopes_are_differences(name):
    """dh/dp with the configurations following is the difference of readings between mechanisms with
    other numbers.
    """
    mechanism = symkin.load(name)
    data, _ = taken(mechanism, RICH[name], count=6)
    names = default_parameters(mechanism, data.observed)
    model = build_model(mechanism, data, names)
    z = solve_configurations(model, data, model.nominal).z
    e = model.evaluate(z, data.joints, model.nominal, data.quaternions)
    rng = np.random.default_rng(1)
    for k in rng.choice(len(names), 4, replace=False):
        step, sides = 1e-4 * model.scales[k], []
        for sign in (1.0, -1.0):
            other = with_parameters(mechanism, {names[k]: model.nominal[k] + sign * step})
            there = build_model(other, data, ())
            at = solve_configurations(there, data, np.zeros(0), z=z).z
            sides.append(there.evaluate(at, data.joints, np.zeros(0), data.quaternions).readings)
        np.testing.assert_allclose(
            e.slopes[:, :, k], (sides[0] - sides[1]) / 2e-4, rtol=1e-5, atol=1e-5
        )


# --- parameters -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    in_gate(
        [
            "ankle",
            "double_wishbone",
            "excavator_bucket",
            "parallel_gripper",
            "hexapod_stack",
            "jansen_leg",
        ],
        ["ankle", "hexapod_stack", "parallel_gripper"],
    ),
)
def test_a_written_number_is_read_back(name):
    """Every number stands in the file where the closure reads it, rods' lengths and named points
    too.
    """
    mechanism, rng = symkin.load(name), np.random.default_rng(0)
    read = tuple(o.name for o in observables(mechanism).values() if o.kind == "point")
    values = geometry_parameters(mechanism, read)
    moved = {
        n: v + 1e-3 * rng.uniform(-1, 1)
        for n, v in values.items()
        if "axis" not in n and "quaternion" not in n
    }
    found = geometry_parameters(parse(with_parameters(mechanism, moved).to_toml()), read)
    assert {n: found[n] for n in moved} == pytest.approx(moved, abs=1e-12)


@pytest.mark.parametrize(
    "name",
    in_gate(
        ["ankle", "double_wishbone", "parallel_gripper", "stephenson_six_bar", "hexapod_stack"],
        ["ankle", "hexapod_stack"],
    ),
)
def test_another_reference_reads_the_same(name):
    """Along each change of the reference configuration no reading moves."""
    mechanism = symkin.load(name)
    data, _ = taken(mechanism, RICH.get(name, ["pose"]), count=8)
    names = tuple(
        n
        for n in parameter_names(mechanism, data.observed)
        if not n.endswith(".scale") and n.split(".")[0] not in ("world", "target")
    )
    model = build_model(mechanism, data, names)
    z = solve_configurations(model, data, model.nominal).z
    slopes = model.evaluate(z, data.joints, model.nominal, data.quaternions).slopes
    motions = list(
        reference_motions(mechanism, dict(zip(names, model.nominal, strict=True)), data.observed)
    )
    assert motions
    for text, velocity in motions:
        direction = np.array([velocity.get(n, 0.0) for n in names]) / model.scales
        # readings move by rounding of the single effects, which are of the size of the direction
        assert np.max(np.abs(slopes @ direction)) < 1e-8 * np.linalg.norm(direction) * max(
            1.0, np.max(np.abs(slopes))
        ), text


@pytest.mark.parametrize(
    "name",
    in_gate(
        [*(name for name in RICH if name != "zhao2000"), "klann_leg", "planetary_gear"],
        ["ankle", "four_bar", "parallel_gripper", "planetary_gear"],
    ),
)
def test_what_is_identified_by_default_is_minimal(name):
    """With everything read that may be, all default parameters have an effect of their own."""
    mechanism = symkin.load(name)
    wanted = [
        o.name
        for o in observables(mechanism).values()
        if o.kind in ("joint", "point", "position", "orientation")
    ]
    noise = Noise(1e-6, 1e-6, position=1e-3, orientation=1e-6)
    data, _ = taken(
        mechanism, [*(["pose"] if mechanism.platform_link else []), *wanted], count=40, noise=noise
    )
    found = identifiability(mechanism, data)
    assert found.rank == len(found.names), found.unobservable


def test_angles_alone_tell_neither_size_nor_place():
    """Of a four-bar with encoders on crank and follower three ratios of lengths and both encoders'
    offsets are told: 5 of 9, and the rest has a name.
    """
    data = read_of_four_bar(linkages.POINTS, np.random.default_rng(0), pen=False)
    found = identifiability(parse(linkages.toml()), data)
    assert found.rank == 5
    assert set(found.unobservable) == {
        "base frame translation x",
        "base frame translation y",
        "base frame yaw (about z)",
        "size of the whole mechanism",
    }
    assert any("hold one length" in text for text in found.advice)


def test_out_of_plane_numbers_of_a_planar_loop_are_bound():
    """An axis of a planar loop cannot be tilted alone: it is no parameter by default, and refused
    by name.
    """
    four_bar = parse(linkages.toml())
    assert "crank_pin.axis.x" in parameter_names(four_bar)
    assert "crank_pin.axis.x" not in default_parameters(four_bar)
    data = read_of_four_bar(linkages.POINTS, np.random.default_rng(0))
    with pytest.raises(
        InputError, match="a loop that is planar or spherical, which could no longer move"
    ):
        calibrate(four_bar, data, parameters=["crank_pin.axis.x"])


# --- fits -----------------------------------------------------------------------------------------


def test_a_four_bar_is_recovered_within_its_deviations():
    """Points off by 0.5 mm and an encoder's offset, from cranks of full turns: chi-square has its
    degrees of freedom, and errors over their standard deviations have variance one.
    """
    scores, chances = [], []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        true, offset = linkages.built(rng), rng.uniform(-0.05, 0.05)
        found = calibrate(parse(linkages.toml()), read_of_four_bar(true, rng, offset=offset))
        wanted = {
            f"{linkages.PATHS[n]}.{k}": v
            for n, point in true.items()
            for k, v in zip("xy", point, strict=True)
        }
        wanted |= {"follower.zero": offset, "coupler.points.pen.z": 0.0}
        assert found.believable
        chances.append(found.p_value)
        scores += [(p.value - wanted[p.name]) / p.sigma for p in found.parameters]
    assert len(scores) == 6 * 12
    assert 0.7 < np.sqrt(np.mean(np.square(scores))) < 1.35
    assert min(chances) > 0.005


@pytest.mark.parametrize("stated", ["point.pen", "follower"])
def test_readings_without_a_deviation_count_beside_those_with_one(stated):
    """Where the noise of one instrument is stated and that of the other is not, clean readings of
    both are kept and weigh: errors are as large as their standard deviations say.
    """
    scores = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        true = linkages.built(rng)
        data = read_of_four_bar(true, rng)
        readings = [r if r.name == stated else replace(r, sigma=None) for r in data.readings]
        found = calibrate(parse(linkages.toml()), replace(data, readings=readings))
        assert not found.outliers
        other = next(r.name for r in readings if r.name != stated)
        assert any(f"standard deviations of {other} are missing" in n for n in found.notes)
        wanted = {f"{linkages.PATHS[n]}.{k}": point for n, point in true.items() for k in "xy"}
        scores += [
            (p.value - wanted[p.name]["xy".index(p.name[-1])]) / p.sigma
            for p in found.parameters
            if p.name in wanted
        ]
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.5


@pytest.mark.parametrize(
    "name",
    in_gate(
        ["stephenson_six_bar", "ankle", "double_wishbone", "zhao2000"],
        ["double_wishbone", "zhao2000"],
    ),
)
def test_a_machine_is_recovered_from_its_readings(name):
    """Readings of a machine with other numbers: the corrected file gives them within the noise, and
    what is read of new configurations.
    """
    mechanism, rng = symkin.load(name), np.random.default_rng(3)
    noise = Noise(1e-4, 1e-6, position=2e-3, orientation=1e-5, distance=2e-3, inclination=1e-5)
    read = tuple(o for o in RICH[name] if o != "pose")
    names = [
        n for n in default_parameters(mechanism, read) if "axis" not in n and "quaternion" not in n
    ]
    values = geometry_parameters(mechanism, read)
    spread = 2e-4 * mechanism.characteristic_length
    true = with_parameters(
        mechanism,
        {n: values[n] + spread * rng.uniform(-1, 1) for n in names if not n.endswith("zero")},
    )
    data, _ = taken(true, RICH[name], count=40, noise=noise)
    found = calibrate(mechanism, data, residual="maximum likelihood", outliers="ignore")
    assert found.status == "ok"
    assert found.p_value > 1e-3
    fresh, _ = taken(true, RICH[name], count=12, seed=9)
    there = build_model(found.corrected, fresh, ())
    at = solve_configurations(there, fresh, np.zeros(0))
    assert at.solved.all()
    h = there.evaluate(at.z, fresh.joints, np.zeros(0), fresh.quaternions).readings
    own = [
        k for k, (kind, _) in enumerate(there.columns) if kind not in ("position", "orientation")
    ]
    wanted = np.hstack([r.values for r in fresh.readings])
    off = np.abs(h[:, own] - wanted) / np.where(there.angular[own], 1e-4, 0.02)
    assert np.sqrt(np.mean(off**2)) < 1.0


def test_the_other_assembly_mode_is_found():
    """Readings of a four-bar that was put together the other way than its file's reference: the
    mode that fits is taken.
    """
    rng = np.random.default_rng(7)
    true, crank = linkages.built(rng, 0.2), rng.uniform(-np.pi, np.pi, 30)
    follower, pen, _, _ = linkages.readings(true, crank, side=-1.0)
    readings = [
        symkin.Reading("follower", follower + rng.normal(0, ANGLE, 30), ANGLE),
        symkin.Reading(
            "point.pen",
            np.column_stack([pen, 0.0 * crank]) + rng.normal(0, LENGTH, (30, 3)),
            LENGTH,
        ),
    ]
    found = calibrate(
        parse(linkages.toml()), symkin.Measurements(crank[:, None], readings=readings)
    )
    assert found.believable
    assert found.values["coupler.points.pen.x"] == pytest.approx(true["pen"][0], abs=0.1)


def test_a_wrong_reading_of_an_encoder_is_named():
    """One follower reading off by a degree is left out and named by its joint."""
    rng = np.random.default_rng(2)
    data = read_of_four_bar(linkages.POINTS, rng)
    values = np.array(data.readings[0].values)
    values[17] += np.radians(1.0)
    data = symkin.Measurements(
        data.joints, readings=[symkin.Reading("follower", values, ANGLE), data.readings[1]]
    )
    found = calibrate(parse(linkages.toml()), data)
    assert [(o.configuration, o.kind) for o in found.outliers] == [(17, "follower")]
    assert "angle +1 deg" in found.outliers[0].reason


UNLIKE = [*product([5, 50], [None, LENGTH])]
"""How many times worse than its share an encoder is, and what is stated of the tracker beside."""


def unlike_instruments(seed, wrong=()):
    """A fit to readings of instruments of unlike precision, positions of some postures wrong by ten
    deviations, and the encoder's deviation over that by which it was weighed.
    """
    factor, stated = UNLIKE[seed % len(UNLIKE)]
    rng = np.random.default_rng(seed)
    data = read_of_four_bar(linkages.POINTS, rng)
    encoder, pen = data.readings
    worse = encoder.values + rng.normal(0, factor * ANGLE, encoder.values.shape)
    places = np.array(pen.values)
    places[[*wrong], 0] += 10 * LENGTH
    readings = [symkin.Reading("follower", worse), symkin.Reading("point.pen", places, stated)]
    found = calibrate(parse(linkages.toml()), replace(data, readings=readings))
    said = any("estimated from the residuals: follower" in note for note in found.notes)
    assert said == ("follower" in found.problem.estimated)
    return found, found.problem.readings.sigma[0, 0] / (factor * ANGLE)


def most_by_chance(count, share, tail=1e-3):
    """The most of `count` independent events of this probability that chance makes, but for a
    `tail` of the binomial distribution.
    """
    terms = [math.comb(count, k) * share**k * (1 - share) ** (count - k) for k in range(count + 1)]
    return next(k for k in range(count + 1) if sum(terms[k + 1 :]) < tail)


def test_clean_readings_of_instruments_of_unlike_precision_are_kept():
    """The encoder is far worse than its share, and its noise is not stated: it is estimated, and of
    20 clean sets no more have a reading left out than the level says, by the binomial distribution.
    """
    spoilt, count = 0, 20
    for seed in range(count):
        found, ratio = unlike_instruments(seed)
        assert 0.5 < ratio < 2.0
        spoilt += bool(found.outliers or found.given_up)
    assert spoilt <= most_by_chance(count, OUTLIER_LEVEL)


def test_a_wrong_reading_beside_a_worse_instrument_is_named():
    """A position that is off by ten deviations is left out, whatever the encoder is like and the
    file states.
    """
    for seed in range(2 * len(UNLIKE)):
        found, _ = unlike_instruments(seed, wrong=[17])
        assert (17, "point.pen") in [(o.configuration, o.kind) for o in found.outliers]


def test_what_a_plane_holds_is_no_precision():
    """A third of a tracker's residuals is zero, heights over a plane that nothing moves: its
    deviation is that of the others.
    """
    data = read_of_four_bar(linkages.POINTS, np.random.default_rng(3))
    encoder, pen = data.readings
    flat = np.column_stack([pen.values[:, :2], np.zeros(len(pen.values))])
    readings = [symkin.Reading("follower", encoder.values), symkin.Reading("point.pen", flat)]
    found = calibrate(parse(linkages.toml()), replace(data, readings=readings))
    assert 0.75 < found.problem.estimated["point.pen"] / LENGTH < 1.3
    assert not found.outliers


def test_a_scale_of_an_encoder_is_identified():
    """A follower's encoder that reads 1 % too much: its factor is 1 / 1.01."""
    data = read_of_four_bar(linkages.POINTS, np.random.default_rng(4), noise=0.0)
    reading = symkin.Reading("follower", 1.01 * data.readings[0].values, ANGLE)
    found = calibrate(
        parse(linkages.toml()),
        symkin.Measurements(data.joints, readings=[reading, data.readings[1]]),
        parameters=["follower.scale"],
    )
    assert found.values["follower.scale"] == pytest.approx(1 / 1.01, rel=1e-9)


# --- files and refusals ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", RICH)
def test_a_file_reads_back(tmp_path, name):
    """Columns of all kinds are read back with every digit."""
    mechanism = symkin.load(name)
    data, _ = taken(
        mechanism,
        RICH[name],
        count=5,
        noise=Noise(1e-3, 1e-4, position=0.1, orientation=1e-4, distance=0.1, inclination=1e-4),
    )
    path = tmp_path / "data.csv"
    path.write_text(measurements_text(mechanism, data))
    found = read_measurements(path, mechanism).measurements
    assert set(found.observed) == set(data.observed)
    for reading in data.readings:
        other = next(r for r in found.readings if r.name == reading.name)
        np.testing.assert_allclose(other.values, reading.values, rtol=1e-14, atol=1e-14)
        np.testing.assert_allclose(other.sigma, reading.sigma, rtol=1e-14)


def test_columns_of_the_platforms_link_are_those_of_the_platform(tmp_path):
    """foot.x of an ankle is x; both together are refused."""
    path = tmp_path / "data.csv"
    path.write_text(
        "upper_motor[deg],lower_motor[deg],foot.x[mm],sigma_foot.x[mm]\n0,0,1.5,0.1\n1,2,2.5,0.1\n"
    )
    data = read_measurements(path, symkin.load("ankle")).measurements
    assert data.position[:, 0].tolist() == [1.5, 2.5]
    assert data.sigma("position")[:, 0].tolist() == [0.1, 0.1]
    path.write_text(
        "upper_motor[deg],lower_motor[deg],foot.x[mm],x[mm]\n0,0,1.5,0.1\n1,2,2.5,0.1\n"
    )
    with pytest.raises(InputError, match=r"'foot.x' and 'x' both mean 'x'"):
        read_measurements(path, symkin.load("ankle"))


@pytest.mark.parametrize(
    ("name", "columns", "words"),
    [
        ("four_bar", "folower[deg]", "column 'folower' is unknown (do you mean 'follower'?"),
        ("stephenson_six_bar", "point.coupler_pt.x[mm]", "do you mean 'point.coupler_point.x'"),
        ("ankle", "distance.toe.hel[mm]", "do you mean 'distance.toe.heel'?"),
        ("ankle", "point.x[mm]", "column 'point.x' is unknown"),
        ("four_bar", "coupler.roll[deg]", "column 'coupler.roll' is unknown"),
        ("four_bar", "x[mm]", "column 'x' is of a platform, and four_bar has no platform link"),
        (
            "four_bar",
            "follower[deg],sigma_follower_pin[deg]",
            "'sigma_follower_pin' stands there without follower_pin",
        ),
        ("four_bar", "coupler.qw,coupler.qx,coupler.qy", "column 'coupler.qz' is missing"),
        (
            "four_bar",
            "colour[mm]",
            "there is no column of any reading beside the joints; unknown: 'colour",
        ),
    ],
)
def test_wrong_columns_are_refused(tmp_path, name, columns, words):
    """A column that looks like a reading and is none is named, with the nearest; so is what a
    reading lacks.
    """
    mechanism = symkin.load(name)
    head = [f"{c.name}[deg]" for c in mechanism.actuated]
    path = tmp_path / "data.csv"
    path.write_text(
        ",".join([*head, columns])
        + "\n"
        + ",".join(["1"] * (len(head) + columns.count(",") + 1))
        + "\n"
    )
    with pytest.raises(InputError) as error:
        read_measurements(path, mechanism)
    assert words in str(error.value)


@pytest.mark.parametrize(
    ("name", "reading", "words"),
    [
        ("double_wishbone", "lower_ball", "is a spherical joint, which no encoder reads"),
        ("ankle", "point.tow", "do you mean 'point.toe'?"),
        ("stephenson_six_bar", "crank", "nothing of stephenson_six_bar is read as 'crank'"),
    ],
)
def test_what_cannot_be_read_is_refused(name, reading, words):
    mechanism = symkin.load(name)
    data = symkin.Measurements(
        np.zeros((2, len(mechanism.actuated))), readings=[symkin.Reading(reading, np.zeros(2))]
    )
    with pytest.raises(InputError, match=words):
        calibrate(mechanism, data)


def test_a_platform_that_is_not_there_is_not_read():
    data = symkin.Measurements(np.zeros((2, 1)), position=np.zeros((2, 3)))
    with pytest.raises(InputError, match=r"position: four_bar has no platform link"):
        calibrate(symkin.load("four_bar"), data)


def test_joints_that_leave_a_freedom_are_refused():
    """The rack alone does not tell where a wheel is."""
    data = symkin.Measurements(
        np.linspace(-10, 10, 6)[:, None], position=np.tile([0.0, 760.0, 320.0], (6, 1))
    )
    with pytest.raises(InputError, match=r"the actuated joints \(rack\) do not determine the pose"):
        calibrate(symkin.load("five_link_suspension"), data)


def test_a_link_that_turns_idly_has_no_orientation():
    """A rod made of a link between two spherical joints spins as it likes."""
    four_bar = symkin.load("four_bar")
    pins = [e.joint for e in four_bar.link_joints]
    loose = symkin.Mechanism(
        "loose",
        link_joints=[
            symkin.LinkJoint(pins[0], ["base", "crank_link"]),
            symkin.LinkJoint(Joint("a", "S", pins[1].point), ["crank_link", "rod"]),
            symkin.LinkJoint(Joint("b", "S", pins[2].point), ["rod", "rocker"]),
            symkin.LinkJoint(pins[3], ["base", "rocker"]),
        ],
    )
    data = symkin.Measurements(
        np.ones((2, 1)),
        readings=[symkin.Reading("rod.orientation", np.tile([1.0, 0, 0, 0], (2, 1)))],
    )
    with pytest.raises(InputError, match="link 'rod' turns idly"):
        calibrate(loose, data)
