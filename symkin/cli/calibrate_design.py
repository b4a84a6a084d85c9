"""`symkin calibrate simulate` and `plan`: measurements as a measuring system would take them, and
those worth taking.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from symkin.cli.calibrate_options import (
    BoxOption,
    CriterionName,
    CsvOption,
    DistanceOption,
    ForceOption,
    GroupsOption,
    NoiseDistance,
    NoiseGroup,
    NoiseInclination,
    NoiseJoints,
    NoiseOrientation,
    NoisePosition,
    PatternOption,
    PosturesOption,
    RandomGroupsOption,
    RandomPosturesOption,
    ReadingsOption,
    Shape,
    SpinOption,
    TiltOption,
)
from symkin.cli.help import HOW, OUTPUT, POSTURES, READINGS
from symkin.cli.options import MechArgument, SeedOption, check_output, choice
from symkin.cli.quantities import (
    angle_pairs,
    check_noise,
    distance_points,
    joint_quantities,
    noise_quantity,
    quantity,
)
from symkin.cli.reading import loaded, reads_robots
from symkin.errors import InputError
from symkin.files.written_files import check_own_file, write_own_file
from symkin.formats.read_options import ReadOptions
from symkin.ignored_options import refuse_ignored

if TYPE_CHECKING:
    from symkin.calibration.design.simulation import Noise
    from symkin.calibration.estimate.workspace import Workspace
    from symkin.model.mechanism import Mechanism

_LIMIT_MARGIN = 0.02
"""Share of each joint's range that a plan keeps free at its limits: the true geometry is not the
nominal one.
"""
_DEFAULT_ANGULAR_NOISE = "0.001deg"
"""Standard deviation of angular readings where none is given."""
_DEFAULT_CONFIGURATIONS = 40
"""Random postures that are simulated where no count is given."""
_DEFAULT_RANGE = "20deg"
"""Range of inclinations and of turns about z where none is given."""


@reads_robots
def simulate(
    mech: MechArgument,
    read: ReadOptions,
    output: CsvOption,
    postures: RandomPosturesOption = None,
    groups: RandomGroupsOption = None,
    readings: ReadingsOption = "",
    truth: Annotated[
        str | None,
        typer.Option(
            metavar="TRUTH",
            help="Mechanism that is measured, name or file. Default: MECH itself.",
            rich_help_panel=POSTURES,
        ),
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option(
            metavar="PLAN.csv",
            help="Take the postures and groups of a plan.",
            rich_help_panel=POSTURES,
        ),
    ] = None,
    noise_joints: NoiseJoints = None,
    noise_group: NoiseGroup = None,
    noise_inclination: NoiseInclination = None,
    noise_position: NoisePosition = None,
    noise_orientation: NoiseOrientation = None,
    distance: DistanceOption = None,
    noise_distance: NoiseDistance = None,
    noise_shape: Annotated[
        Shape,
        choice(
            Shape,
            "--noise-shape",
            "Distribution of the noise, of the standard deviations given.",
            READINGS,
        ),
    ] = Shape.normal,
    euler: Annotated[
        str | None,
        typer.Option(
            metavar="ZYX",
            help="Write orientations as Euler angles of this sequence.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    hide_sequence: Annotated[
        bool,
        typer.Option(
            "--hide-sequence", help="Leave the sequence out of the header.", rich_help_panel=OUTPUT
        ),
    ] = False,
    box: BoxOption = None,
    tilt: TiltOption = None,
    spin: SpinOption = None,
    seed: SeedOption = 0,
    force: ForceOption = False,
) -> None:
    """Write measurements as a measuring system would take them, of random postures or those of a
    plan.
    """
    import numpy as np

    from symkin.calibration.data.column_names import DISTANCE
    from symkin.calibration.data.files import measurements_text, read_measurements
    from symkin.calibration.design.simulation import (
        group_numbers,
        planned_configurations,
        platform_kinds,
        random_configurations,
        simulate_readings,
    )
    from symkin.formats.load import is_robot

    check_output(output, mech, truth, plan)
    check_own_file(output, force=force)
    mechanism = loaded(mech, read)
    true = mechanism
    if truth is not None:
        # a robot's file is read as MECH is
        true = loaded(truth, read if is_robot(Path(truth)) else ReadOptions())
    _check_same_joints(mechanism, true)
    kinds = _split_names(readings)
    beside = [*kinds, *(distance or ())]
    _refuse_unread_noise(mechanism, kinds, noise_inclination, noise_position, noise_orientation)
    _refuse_unread_drawing(true, plan, postures, groups, box=box, tilt=tilt, spin=spin)
    if not distance and not any(kind.startswith("distance.") for kind in kinds):
        refuse_ignored(
            {"--noise-distance": noise_distance},
            "no distance is read",
            "name one with --distance, or with --readings distance.A.B",
        )
    if not {"orientation", "pose"} & set(kinds):
        refuse_ignored({"--euler": euler}, "no orientation is read", "name it with --readings")
    if euler is None:
        refuse_ignored(
            {"--hide-sequence": hide_sequence},
            "orientations are written as quaternions",
            "name a sequence with --euler",
        )
    noise = _noise(
        mechanism,
        noise_joints,
        noise_group,
        noise_inclination,
        noise_position,
        noise_orientation,
        noise_shape,
    )
    if noise_distance is not None:
        noise = replace(
            noise, distance=noise_quantity(noise_distance, "length", mechanism, "noise-distance")
        )
    rng = np.random.default_rng(_checked_seed(seed))
    workspace = _workspace(true, box, tilt, spin)
    if plan is not None:
        planned = read_measurements(plan, mechanism)
        _check_anything_read(planned.measurements.groups is not None, beside, noise_group)
        numbers, made = planned_configurations(
            workspace, mechanism, planned.measurements, planned.wedges, noise, rng
        )
    else:
        _check_anything_read(bool(groups), beside, noise_group)
        platform_kinds(true, kinds, grouped=bool(groups))
        numbers = group_numbers(
            _DEFAULT_CONFIGURATIONS if postures is None else postures, groups or 0
        )
        made = random_configurations(workspace, numbers, noise, rng)
    ends = {
        DISTANCE + name: points for name, points in distance_points(distance, mechanism).items()
    }
    measured = simulate_readings(true, made, numbers, kinds, noise, rng, ends)
    comments = [f"fit with --distance {shlex.quote(text)}" for text in distance or ()]
    write_own_file(
        output,
        measurements_text(
            mechanism, measured, sequence=euler, hidden=hide_sequence, comments=comments
        ),
    )
    print(
        f"written: {output}, {len(made)} postures in {len(set(numbers.tolist()) - {-1})} groups, "
        f"seed {seed}"
    )


@reads_robots
def plan(
    mech: MechArgument,
    read: ReadOptions,
    output: CsvOption,
    postures: PosturesOption = 40,
    groups: GroupsOption = 5,
    criterion: Annotated[
        CriterionName,
        choice(
            CriterionName,
            "--criterion",
            "I: pose variance over the workspace; A: parameters; D: their determinant.",
            HOW,
        ),
    ] = CriterionName.I,
    wedges: Annotated[
        str | None,
        typer.Option(
            metavar="A:B,...",
            help="Inclinations alpha:beta that groups may have. Default: level, and +-tilt.",
            rich_help_panel=POSTURES,
        ),
    ] = None,
    readings: ReadingsOption = "",
    parameters: PatternOption = None,
    raw: Annotated[
        bool,
        typer.Option(
            "--raw",
            help="Judge poses in their own frames, not after the best base and tool alignment.",
            rich_help_panel=HOW,
        ),
    ] = False,
    noise_joints: NoiseJoints = None,
    noise_group: NoiseGroup = None,
    noise_inclination: NoiseInclination = None,
    noise_position: NoisePosition = None,
    noise_orientation: NoiseOrientation = None,
    box: BoxOption = None,
    tilt: TiltOption = None,
    spin: SpinOption = None,
    seed: SeedOption = 0,
    force: ForceOption = False,
) -> None:
    """Choose postures and wedges that identify the geometry best, and say what they will reach."""
    from symkin.calibration.design.planning import accuracy_text, plan_measurements, plan_text
    from symkin.calibration.design.simulation import observed_kinds
    from symkin.calibration.fit_file import match_parameters

    check_output(output, mech)
    check_own_file(output, force=force)
    mechanism = loaded(mech, read)
    kinds = _split_names(readings)
    _check_anything_read(groups != 0, kinds, noise_group)
    _refuse_unread_noise(mechanism, kinds, noise_inclination, noise_position, noise_orientation)
    noise = _noise(
        mechanism,
        noise_joints,
        noise_group,
        noise_inclination,
        noise_position,
        noise_orientation,
        Shape.normal,
    )
    told = tuple(o.name for o in observed_kinds(mechanism, kinds))
    made = plan_measurements(
        _workspace(mechanism, box, tilt, spin, _LIMIT_MARGIN),
        postures,
        noise,
        groups=groups,
        criterion=criterion.value,
        seed=_checked_seed(seed),
        wedges=None if wedges is None else angle_pairs(wedges, mechanism, "wedges"),
        readings=kinds,
        parameters=None if parameters is None else match_parameters(mechanism, parameters, told),
        aligned=not raw,
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
    print(f"expected pose error: {accuracy_text(mechanism, made.accuracy)}")
    print(f"the same of random postures: {accuracy_text(mechanism, made.random)}")
    print(f"written: {output}, {len(made.groups)} postures, {criterion.value}-optimal, seed {seed}")


# --- helpers --------------------------------------------------------------------------------------


def _refuse_unread_noise(
    mechanism: Mechanism,
    readings: Sequence[str],
    inclination: str | None,
    position: str | None,
    orientation: str | None,
) -> None:
    """Refuse the noise of readings that are not taken."""
    from symkin.calibration.design.simulation import observed_kinds

    taken = {
        "position" if o.kind == "point" else o.kind for o in observed_kinds(mechanism, readings)
    } | set(readings)
    for name, noise in {
        "inclination": inclination,
        "position": position,
        "orientation": orientation,
    }.items():
        if name not in taken and (name == "inclination" or "pose" not in taken):
            refuse_ignored(
                {f"--noise-{name}": noise}, f"no {name} is read", "name it with --readings"
            )


def _refuse_unread_drawing(
    mechanism: Mechanism,
    plan: Path | None,
    postures: int | None,
    groups: int | None,
    *,
    box: str | None,
    tilt: str | None,
    spin: str | None,
) -> None:
    """Refuse what random postures are drawn by where a plan gives the postures, and a workspace of
    poses where an arm is drawn by its joints.
    """
    workspace = {"--box": box, "--tilt": tilt, "--spin": spin}
    if plan is not None:
        drawn = {"--postures": postures, "--groups": groups, **workspace}
        refuse_ignored(drawn, "the plan gives the postures and their groups", "leave --plan out")
    elif _drawn_by_joints(mechanism):
        unread = {
            name: value for name, value in workspace.items() if name != "--tilt" or not groups
        }
        what = (
            "a serial arm"
            if mechanism.serial
            else f"{mechanism.name}, whose joints carry what they move,"
        )
        refuse_ignored(unread, f"postures of {what} are drawn by its joints, within their limits")


def _drawn_by_joints(mechanism: Mechanism) -> bool:
    from symkin.calibration.estimate.workspace import Workspace

    return Workspace.about(mechanism).drawn_by_joints


def _noise(
    m: Mechanism,
    joints: str | None,
    group: str | None,
    inclination: str | None,
    position: str | None,
    orientation: str | None,
    shape: Shape,
) -> Noise:
    from symkin.calibration.design.simulation import Noise

    lengths, angles = (
        1e-6 * m.characteristic_length,
        quantity(_DEFAULT_ANGULAR_NOISE, "angle", m, "noise-joints"),
    )
    if joints is not None:
        values = joint_quantities(joints, m, "noise-joints")
        for value, c in zip(values, m.actuated, strict=True):
            check_noise(float(value), "angle" if c.is_angular else "length", m, "noise-joints")
            lengths, angles = (lengths, float(value)) if c.is_angular else (float(value), angles)
    return Noise(
        lengths=lengths,
        angles=angles,
        group=noise_quantity(_or_default(group), "angle", m, "noise-group"),
        inclination=noise_quantity(_or_default(inclination), "angle", m, "noise-inclination"),
        position=1e-5 * m.characteristic_length
        if position is None
        else noise_quantity(position, "length", m, "noise-position"),
        orientation=noise_quantity(_or_default(orientation), "angle", m, "noise-orientation"),
        distance=1e-5 * m.characteristic_length,
        uniform=shape is Shape.uniform,
    )


def _or_default(text: str | None, default: str = _DEFAULT_ANGULAR_NOISE) -> str:
    """An option's text, or the default where it is not given; an empty one is given."""
    return default if text is None else text


def _split_names(readings: str) -> list[str]:
    return [part.strip() for part in readings.split(",") if part.strip()]


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
            "--readings (inclination, "
            "position, orientation, pose; passive joints, point.NAME, LINK.pose, distance.A.B), or "
            "distances"
        )


def _workspace(
    mechanism: Mechanism, box: str | None, tilt: str | None, spin: str | None, margin: float = 0.0
) -> Workspace:
    from symkin.calibration.estimate.workspace import Workspace

    half = (
        None
        if box is None
        else [quantity(part, "length", mechanism, "box") for part in box.split(",")]
    )
    return Workspace.about(
        mechanism,
        half,
        tilt=quantity(_or_default(tilt, _DEFAULT_RANGE), "angle", mechanism, "tilt"),
        spin=quantity(_or_default(spin, _DEFAULT_RANGE), "angle", mechanism, "spin"),
        margin=margin,
    )


def _checked_seed(seed: int) -> int:
    if seed < 0:
        raise InputError(f"--seed {seed} is negative; whole numbers from 0 are allowed")
    return seed


def _check_same_joints(mechanism: Mechanism, true: Mechanism) -> None:
    ours, theirs = ([(c.name, c.kind) for c in m.actuated] for m in (mechanism, true))
    if (
        ours != theirs
        or mechanism.length_unit != true.length_unit
        or mechanism.angle_unit != true.angle_unit
    ):
        raise InputError(
            f"--truth {true.name}: its actuated joints ({', '.join(n for n, _ in theirs)}; "
            f"{true.length_unit}, {true.angle_unit}) are not those "
            f"of {mechanism.name} ({', '.join(n for n, _ in ours)}; {mechanism.length_unit}, "
            f"{mechanism.angle_unit})"
        )
