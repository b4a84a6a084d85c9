"""A laser tracker's case through the command line: unknown world frame, unknown reflector,
positions only.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

import symkin
from helpers.inside import main
from helpers.tracker import (
    ARM,
    NOISE,
    REFLECTOR,
    WORLD_POSITION,
    WORLD_ROTATION,
    Hexapod,
    Posed,
    arm,
    arm_posed,
)

POSTURES = 70
TRACKER = "all,world.*,target.position.*"
_BASE_FRAME = "leg1.base.*,leg2.base.y,leg2.base.z,leg3.base.z"
HEXAPOD_FRAMES = f"{_BASE_FRAME},{_BASE_FRAME.replace('base', 'platform')}"
ARM_FRAMES = "dh.1.theta,dh.1.d,dh.6.*"


class Hexapods:
    """The hexapod as drawn and as built; the frames of both are those in which the entries of
    `HEXAPOD_FRAMES` are equal.
    """

    names, frames = tuple(f"leg{k}[mm]" for k in range(1, 7)), HEXAPOD_FRAMES

    def __init__(self, rng):
        self.nominal = Hexapod.nominal()
        self.true = self.nominal.spoilt(rng)
        for table in ("base", "platform"):
            getattr(self.true, table)[0] = getattr(self.nominal, table)[0]
            getattr(self.true, table)[1, 1:] = getattr(self.nominal, table)[1, 1:]
            getattr(self.true, table)[2, 2] = getattr(self.nominal, table)[2, 2]
        self.mechanism = self.nominal.mechanism()

    def postures(self, rng):
        return self.true.postures(POSTURES, rng)

    def posed_by(self, found, joints):
        """The same joints with the geometry of a mechanism file."""
        tables = (
            np.array([getattr(limb, key) for limb in found.limbs])
            for key in ("base", "platform", "offset")
        )
        return Hexapod(*tables).posed(joints)


class Arms:
    names, frames = tuple(f"q{k}[rad]" for k in range(1, 7)), ARM_FRAMES

    def __init__(self, rng):
        self.true = ARM + rng.uniform(-0.5, 0.5, ARM.shape)
        self.true[0, :2], self.true[5] = ARM[0, :2], ARM[5]
        self.mechanism = arm()

    def postures(self, rng):
        return arm_posed(self.true, rng.uniform(-1.6, 1.6, (POSTURES, 6)))

    def posed_by(self, found, joints):
        table = np.array(
            [[np.degrees(row.theta), row.d, row.a, np.degrees(row.alpha)] for row in found.dh.rows]
        )
        return arm_posed(table, joints)


def fit(folder, mechanism, text, *options):
    """Exit status of `symkin calibrate fit` into the folder `out`."""
    (folder / "nominal.toml").write_text(mechanism.to_toml())
    (folder / "data.csv").write_text(text)
    arguments = [
        folder / "nominal.toml",
        folder / "data.csv",
        "-o",
        folder / "out",
        "--sigma-position",
        f"{NOISE}mm",
        *options,
    ]
    with pytest.raises(SystemExit) as ended:
        main(["calibrate", "fit", *map(str, arguments)])
    return ended.value.code or 0


def reported(folder):
    return json.loads((folder / "out" / "report.json").read_text())


def identified(report, prefix):
    """Values of three parameters x, y, z and their standard deviations; angles in radians."""
    rows = {p["name"]: p for p in report["parameters"]}
    return np.array(
        [
            [
                np.radians(rows[f"{prefix}.{k}"][what])
                if "rotation" in prefix
                else rows[f"{prefix}.{k}"][what]
                for k in "xyz"
            ]
            for what in ("value", "sigma")
        ]
    )


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("kind", [Hexapods, Arms], ids=["hexapod", "6R arm"])
def test_a_tracker_anywhere_predicts_what_it_has_not_read(tmp_path, kind):
    """Believable, frames held by the least change; the mechanism that was written and the frames of
    the report give the positions of other postures to less than the noise of one reading.
    """
    case = kind(np.random.default_rng(5))
    rng = np.random.default_rng(6)
    assert (
        fit(
            tmp_path,
            case.mechanism,
            case.postures(rng).csv(case.names, rng),
            "--parameters",
            TRACKER,
        )
        == 0
    )
    report, found = (
        reported(tmp_path),
        symkin.load(str(tmp_path / "out" / f"{case.mechanism.name}.toml")),
    )
    assert report["believable"]
    assert not report["unobservable"]
    others: Posed = case.postures(np.random.default_rng(7))
    frames = [
        identified(report, name)[0]
        for name in ("world.position", "world.rotation", "target.position")
    ]
    errors = case.posed_by(found, others.joints).seen(*frames) - others.seen()
    assert np.sqrt(np.mean(errors**2)) < NOISE


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("kind", [Hexapods, Arms], ids=["hexapod", "6R arm"])
def test_the_frames_that_are_found_are_the_simulated_ones(tmp_path, kind):
    """With base and platform frames held where the true geometry has them, world frame and
    reflector are the true ones within six standard deviations, which are small.
    """
    case = kind(np.random.default_rng(8))
    rng = np.random.default_rng(9)
    text = case.postures(rng).csv(case.names, rng)
    assert fit(tmp_path, case.mechanism, text, "--parameters", TRACKER, "--hold", case.frames) == 0
    truth = {
        "world.position": WORLD_POSITION,
        "world.rotation": WORLD_ROTATION,
        "target.position": REFLECTOR,
    }
    for name, true in truth.items():
        value, sigma = identified(reported(tmp_path), name)
        assert np.all(np.abs(value - true) < 6.0 * sigma)
        assert np.all(sigma < (1e-2 if name.endswith("rotation") else 2.0))


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(
    "parameters", ["all,target.position.x", "world.*,target.*", "leg*.offset,world.rotation.z"]
)
def test_any_of_the_frames_may_be_identified(tmp_path, parameters):
    """Each choice of measuring frames ends with a report, of a machine as drawn seen in its own
    frame.
    """
    case = Hexapods(np.random.default_rng(10))
    posed = case.nominal.postures(POSTURES, np.random.default_rng(11))
    read = posed.seen(np.zeros(3), np.zeros(3), np.zeros(3)) + NOISE * np.random.default_rng(
        12
    ).normal(size=(POSTURES, 3))
    rows = [",".join([*case.names, "x[mm]", "y[mm]", "z[mm]"])]
    rows += [",".join(map(repr, map(float, row))) for row in np.column_stack([posed.joints, read])]
    assert fit(tmp_path, case.mechanism, "\n".join(rows), "--parameters", parameters) == 0
    report = reported(tmp_path)
    assert report["believable"]
    assert all(
        abs(p["value"]) < 1.0
        for p in report["parameters"]
        if p["name"].startswith(("world", "target"))
    )


@pytest.mark.long
@pytest.mark.slow
def test_a_slip_is_named_through_unknown_frames(capsys, tmp_path):
    """Two leg columns exchanged: not usable, and the reason is theirs."""
    case = Hexapods(np.random.default_rng(13))
    posed, rng = case.postures(np.random.default_rng(14)), np.random.default_rng(15)
    exchanged = Posed(posed.joints[:, [0, 4, 2, 3, 1, 5]], posed.rotations, posed.positions)
    assert (
        fit(tmp_path, case.mechanism, exchanged.csv(case.names, rng), "--parameters", TRACKER) == 3
    )
    assert "leg2 and leg5 look exchanged" in capsys.readouterr().out
