"""`symkin calibrate simulate` and `plan`: measurements as a measuring system would take them, and
those worth taking.
"""

from __future__ import annotations

import shlex
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from symkin.calibration.options import SEED, PlanOptions
from symkin.cli.calibrate_options import (
    MEASURES,
    AllNoise,
    CsvOption,
    ForceOption,
    Noise,
    PatternOption,
    PosturesOption,
    RandomGroupsOption,
    RandomPosturesOption,
    ReadingsOption,
    Space,
)
from symkin.cli.options import MechArgument, check_output, names_from
from symkin.cli.quantities import (
    check_noise,
    distance_points,
    joint_quantities,
    noise_quantity,
    quantity,
)
from symkin.cli.reading import loaded
from symkin.cli.values import Asked
from symkin.errors import InputError
from symkin.files.written_files import check_own_file, write_own_file
from symkin.formats.read_options import ReadOptions
from symkin.verb_options import OUTPUT, POSTURES, READINGS, Option, check_seed, refuse_ignored

if TYPE_CHECKING:
    from symkin.calibration.design import simulation
    from symkin.calibration.estimate.workspace import Workspace
    from symkin.model.mechanism import Mechanism

_LIMIT_MARGIN = 0.02
"""Share of each joint's range that a plan keeps free at its limits: the true geometry is not the
nominal one.
"""
_ANGULAR_NOISE, _LENGTH_NOISE, _JOINT_NOISE = "0.001deg", 1e-5, 1e-6
"""Standard deviation of angular readings where none is given, of lengths and of the lengths of
joints over the size.
"""
_DEFAULT_CONFIGURATIONS = 40
"""Random postures that are simulated where no count is given."""


def simulate(
    mech: MechArgument,
    read: ReadOptions,
    output: CsvOption,
    noise: AllNoise,
    space: Space,
    postures: RandomPosturesOption = None,
    groups: RandomGroupsOption = None,
    readings: ReadingsOption = None,
    truth: Annotated[
        str | None,
        Option(
            "Mechanism that is measured, name or file. Default: MECH itself.", "TRUTH", POSTURES
        ),
    ] = None,
    plan: Annotated[
        Path | None,
        Option("Take the postures and groups of a plan.", "PLAN.csv", POSTURES),
    ] = None,
    noise_shape: Annotated[
        Literal["normal", "uniform"],
        Option("Distribution of the noise, of the standard deviations given.", group=READINGS),
    ] = "normal",
    euler: Annotated[
        str | None,
        Option("Write orientations as Euler angles of this sequence.", "ZYX", OUTPUT),
    ] = None,
    hide_sequence: Annotated[
        bool,
        Option("Leave the sequence out of the header.", group=OUTPUT),
    ] = False,
    seed: Annotated[int, SEED] = 0,
    force: ForceOption = False,
) -> None:
    """Write measurements as a measuring system would take them, of random postures or those of a
    plan.
    """
    import numpy as np

    from symkin.calibration.data.columns import DISTANCE
    from symkin.calibration.data.files import measurements_text, read_measurements
    from symkin.calibration.design import simulation
    from symkin.formats.load import is_robot

    check_output(output, mech, truth, plan)
    check_own_file(output, force=force)
    mechanism = true = loaded(mech, read)
    if truth is not None:
        # a robot's file is read as MECH is
        true = loaded(truth, read if is_robot(Path(truth)) else None)
    _check_same_joints(mechanism, true)
    kinds, distance = names_from(readings or None), noise["distance"] or ()
    _refuse_unread_noise(mechanism, kinds, noise, distance)
    _refuse_unread_drawing(true, plan, postures, groups, space)
    if not {"orientation", "pose"} & set(kinds):
        refuse_ignored({"--euler": euler}, "no orientation is read", "name it with --readings")
    if euler is None:
        refuse_ignored(
            {"--hide-sequence": hide_sequence},
            "orientations are written as quaternions",
            "name a sequence with --euler",
        )
    sigmas = _noise(mechanism, noise, noise_shape)
    check_seed(seed)
    rng = np.random.default_rng(seed)
    workspace = _workspace(true, space)
    planned = None if plan is None else read_measurements(plan, mechanism)
    grouped = bool(groups) if planned is None else planned.measurements.groups is not None
    _check_anything_read(grouped, [*kinds, *distance], noise["noise_group"])
    if planned is not None:
        numbers, made = simulation.planned_configurations(
            workspace, mechanism, planned.measurements, planned.wedges, sigmas, rng
        )
    else:
        simulation.taken_readings(true, kinds, grouped=grouped)
        count = _DEFAULT_CONFIGURATIONS if postures is None else postures
        numbers = simulation.group_numbers(count, groups or 0)
        made = simulation.random_configurations(workspace, numbers, sigmas, rng)
    points = distance_points(noise["distance"], mechanism)
    ends = {DISTANCE + name: pair for name, pair in points.items()}
    measured = simulation.simulate_readings(true, made, numbers, kinds, sigmas, rng, ends)
    comments = [f"fit with --distance {shlex.quote(text)}" for text in distance]
    text = measurements_text(
        mechanism, measured, sequence=euler, hidden=hide_sequence, comments=comments
    )
    write_own_file(output, text)
    print(
        f"written: {output}, {len(made)} postures in {len(set(numbers.tolist()) - {-1})} groups, "
        f"seed {seed}"
    )


def plan(
    mech: MechArgument,
    read: ReadOptions,
    output: CsvOption,
    noise: Noise,
    space: Space,
    options: PlanOptions,
    postures: PosturesOption = 40,
    parameters: PatternOption = None,
    raw: Annotated[
        bool,
        Option("Judge poses in their own frames, not after the best base and tool alignment."),
    ] = False,
    force: ForceOption = False,
) -> None:
    """Choose postures and wedges that identify the geometry best, and say what they will reach."""
    from symkin.calibration.design.planning import plan_measurements, plan_text
    from symkin.calibration.design.simulation import names_beside
    from symkin.calibration.fit_file import match_parameters

    check_output(output, mech)
    check_own_file(output, force=force)
    asked = Asked.of(mech, read)
    mechanism, values = asked.mechanism, asked.values(PlanOptions, options)
    kinds = values.setdefault("readings", [])
    _check_anything_read(values["groups"] != 0, kinds, noise["noise_group"])
    _refuse_unread_noise(mechanism, kinds, noise)
    sigmas = _noise(mechanism, noise, "normal")
    if parameters is not None:
        values["parameters"] = match_parameters(
            mechanism, parameters, names_beside(mechanism, kinds)
        )
    made = plan_measurements(
        _workspace(mechanism, space, _LIMIT_MARGIN), postures, sigmas, aligned=not raw, **values
    )
    write_own_file(output, plan_text(made))
    for k, (alpha, beta) in enumerate(made.wedges):
        held = int((made.groups == k).sum())
        print(
            f"group {k + 1}: {held} postures at alpha {mechanism.angle_out(alpha):g}, beta "
            f"{mechanism.angle_out(beta):g} {mechanism.angle_unit}"
        )
    print(f"rank {made.accuracy.rank} of {made.accuracy.parameters} parameters")
    if made.accuracy.rank < made.observable:
        print(
            f"note: too few postures; these readings can tell {made.observable} combinations of "
            f"parameters"
        )
    print("\n".join(made.expected("postures")))
    print(
        f"written: {output}, {len(made.groups)} postures, {made.criterion}-optimal, "
        f"seed {made.seed}"
    )


# --- helpers --------------------------------------------------------------------------------------


def _refuse_unread_noise(
    mechanism: Mechanism, readings: Sequence[str], noise: Noise, distances: Collection[str] = ()
) -> None:
    """Refuse the noise of readings that are not taken."""
    from symkin.calibration.design.simulation import taken_readings

    read = taken_readings(mechanism, readings)
    taken = {"position" if o.kind == "point" else o.kind for o in read} | {"group"}
    taken |= {"distance"} if distances else set()
    for kind in MEASURES:
        named = "--readings distance.A.B, or --distance" if kind == "distance" else "--readings"
        if kind not in taken:
            given = {f"--noise-{kind}": noise.get(f"noise_{kind}")}
            refuse_ignored(given, f"no {kind} is read", f"name it with {named}")


def _refuse_unread_drawing(
    mechanism: Mechanism,
    plan: Path | None,
    postures: int | None,
    groups: int | None,
    space: Space,
) -> None:
    """Refuse what random postures are drawn by where a plan gives the postures, and a workspace of
    poses where an arm is drawn by its joints.
    """
    from symkin.calibration.estimate.workspace import Workspace

    ranges = {f"--{name}": value for name, value in space.items()}
    if plan is not None:
        drawn = {"--postures": postures, "--groups": groups, **ranges}
        refuse_ignored(drawn, "the plan gives the postures and their groups", "leave --plan out")
    elif Workspace.about(mechanism).drawn_by_joints:
        unread = {name: v for name, v in ranges.items() if name != "--tilt" or not groups}
        what = f"{mechanism.name}, whose joints carry what they move,"
        refuse_ignored(
            unread,
            f"postures of {'a serial arm' if mechanism.serial else what} are drawn by its joints, "
            f"within their limits",
        )


def _noise(m: Mechanism, told: Noise, shape: str) -> simulation.Noise:
    from symkin.calibration.design import simulation

    angle = quantity(_ANGULAR_NOISE, "angle", m, "noise-joints")
    usual = {"angle": angle, "length": _LENGTH_NOISE * m.characteristic_length}
    sigmas: dict[str, Any] = {
        "lengths": _JOINT_NOISE * m.characteristic_length,
        "angles": angle,
    }
    for kind, measure in MEASURES.items():
        text, option = told.get(f"noise_{kind}"), f"noise-{kind}"
        given = usual[measure] if text is None else noise_quantity(str(text), measure, m, option)
        sigmas[kind] = given
    if told["noise_joints"] is not None:
        values = joint_quantities(told["noise_joints"], m, "noise-joints")
        for value, c in zip(values, m.actuated, strict=True):
            measure = "angle" if c.is_angular else "length"
            check_noise(float(value), measure, m, "noise-joints")
            sigmas[f"{measure}s"] = float(value)
    return simulation.Noise(uniform=shape == "uniform", **sigmas)


def _check_anything_read(grouped: bool, readings: list[str], noise_group: str | None) -> None:
    """Refuse what no fit could use: joints alone, and noise of groups that are not asked for."""
    if noise_group is not None and not grouped:
        raise InputError(
            "--noise-group is given and there are no groups; give --groups, or leave --noise-group "
            "out"
        )
    if not grouped and not readings:
        raise InputError(
            "nothing is read beside the joints, and a fit would refuse the file; name --groups, or "
            "--readings (inclination, position, orientation, pose; passive joints, point.NAME, "
            "LINK.pose, distance.A.B), or distances"
        )


def _workspace(mechanism: Mechanism, space: Space, margin: float = 0.0) -> Workspace:
    from symkin.calibration.estimate.workspace import Workspace

    box = space["box"]
    half = None
    if box is not None:
        half = [quantity(part, "length", mechanism, "box") for part in box.split(",")]
    angles = {
        name: quantity(text, "angle", mechanism, name)
        for name, text in (("tilt", space["tilt"]), ("spin", space["spin"]))
        if text is not None
    }
    return Workspace.about(mechanism, half, margin=margin, **angles)


def _check_same_joints(mechanism: Mechanism, true: Mechanism) -> None:
    ours, theirs = (
        f"({', '.join(c.name for c in m.actuated)}; {m.length_unit}, {m.angle_unit})"
        for m in (mechanism, true)
    )
    if ours != theirs or [c.kind for c in mechanism.actuated] != [c.kind for c in true.actuated]:
        raise InputError(
            f"--truth {true.name}: its actuated joints {theirs} are not those of {mechanism.name} "
            f"{ours}"
        )
