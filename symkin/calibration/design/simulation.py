"""Simulate readings as a measuring system would take them of a mechanism with a known geometry, and
differentiate those that would be taken, over their standard deviations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symkin.calibration.data.measurements import NO_GROUP, Measurements, Reading
from symkin.calibration.data.observables import (
    PLATFORM,
    Observable,
    distance_to_base,
    observables,
    observables_named,
    unknown_observable,
)
from symkin.calibration.estimate.configuration_model import build_model, model_of
from symkin.calibration.estimate.configurations import (
    ClosedConfigurations,
    refuse_undetermined,
    solve_configurations,
    with_poses,
)
from symkin.calibration.estimate.problem import CalibrationProblem, build_calibration
from symkin.calibration.estimate.residuals import noise_of, whitening
from symkin.calibration.estimate.state import evaluate_at, joint_covariance
from symkin.calibration.estimate.workspace import Workspace
from symkin.closure.closure import build_closure
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.position.transfer import many_elsewhere
from symkin.spatial.rotation import multiply, quaternion_from_rotation_vector
from symkin.text import counted

READING_CHOICES = ("inclination", "position", "orientation", "pose")
"""What may be read of the platform beside the joints; a pose is position and orientation. Groups
need nothing of these.
"""
MAX_CONFIGURATIONS = 100_000
"""More rows than this are taken for a typing mistake."""


@dataclass(frozen=True)
class Noise:
    """Standard deviations of independent errors: of joints by kind (length unit, radians), of the
    equality of inclination in a group, of inclinations, positions (each component), orientations
    (each component of a rotation vector) and distances. `uniform`: uniform of the same standard
    deviation, half width sqrt(3) sigma, in place of normal.
    """

    lengths: float = 0.0
    angles: float = 0.0
    group: float = 0.0
    inclination: float = 0.0
    position: float = 0.0
    orientation: float = 0.0
    distance: float = 0.0
    uniform: bool = False

    def draw(
        self, sigma: float | np.ndarray, shape: tuple[int, ...], rng: np.random.Generator
    ) -> np.ndarray:
        unit = (
            rng.uniform(-np.sqrt(3), np.sqrt(3), shape) if self.uniform else rng.normal(size=shape)
        )
        return sigma * unit

    def joints(self, mechanism: Mechanism) -> np.ndarray:
        """Standard deviation of each actuated joint (a,)."""
        return np.array([self.angles if c.is_angular else self.lengths for c in mechanism.actuated])

    def of(self, kind: str, *, angular: bool = True) -> float:
        """Standard deviation of the readings of a kind; of joints those of angles or lengths."""
        others = {"point": "position", "joint": "angles" if angular else "lengths"}
        return float(getattr(self, others.get(kind, kind)))


def taken_readings(
    mechanism: Mechanism, readings: Sequence[str], *, grouped: bool = False
) -> tuple[Observable, ...]:
    """Return what readings are by their names, those of the platform first; the pose of a link is
    its position and its orientation. Raises InputError for what is unknown, and for readings and
    groups (of equal inclination) of a platform that is not there.
    """
    own = [kind for kind in readings if kind in READING_CHOICES]
    if (own or grouped) and mechanism.platform_link is None:
        what = f"readings: {own[0]!r} is read" if own else "groups: equal inclination is that"
        raise InputError(
            f"{what} of a platform, and {mechanism.name} has no platform link; name it by "
            f"[platform] link, or "
            "read named points (point.NAME) and other links (LINK.pose, LINK.position, "
            "LINK.orientation, LINK.inclination)"
        )
    known, names = observables(mechanism), list[str]()
    for name in (name for name in readings if name not in own):
        link, _, last = name.rpartition(".")
        whole = [f"{link}.position", f"{link}.orientation"] if last == "pose" else [name]
        if not all(part in known for part in whole):
            besides = READING_CHOICES if mechanism.platform_link is not None else ()
            raise InputError(f"readings: {unknown_observable(mechanism, name, besides)}")
        names += whole
    own += ["position", "orientation"] if "pose" in own else []
    platform = [o for kind, o in PLATFORM.items() if kind in own]
    return (*platform, *observables_named(mechanism, names))


def names_beside(mechanism: Mechanism, readings: Sequence[str]) -> tuple[str, ...]:
    """Name those of the readings that are not of the platform."""
    return tuple(o.name for o in taken_readings(mechanism, readings) if o.of)


def group_numbers(configurations: int, groups: int) -> np.ndarray:
    """Number the groups 0, 0, ..., 1, 1, ...: `configurations` in `groups` as equal as may be, each
    of two at least.
    """
    if not 1 <= configurations <= MAX_CONFIGURATIONS:
        raise InputError(
            f"{configurations} postures are asked for; allowed: 1 to {MAX_CONFIGURATIONS}"
        )
    if groups < 0:
        raise InputError(f"{groups} groups are asked for; allowed: 0 (none) or more")
    if groups > configurations // 2:
        raise InputError(
            f"{groups} groups for {counted(configurations, 'posture')}, and two "
            f"postures in each are needed: at least {2 * groups} "
            f"postures for {counted(groups, 'group')}, or fewer --groups"
        )
    if groups == 0:
        return np.full(configurations, NO_GROUP)
    return np.sort(np.arange(configurations) % groups)


def random_configurations(
    workspace: Workspace, groups: np.ndarray, noise: Noise, rng: np.random.Generator
) -> ClosedConfigurations:
    """Draw random closed configurations; those of one group share the inclination of its wedge, but
    for the noise of that.
    """
    if np.all(groups == NO_GROUP):
        return workspace.draw(workspace.inclinations(len(groups), rng), rng, held=False)
    wanted = workspace.inclinations(groups.max() + 1, rng)[groups]
    return workspace.draw(wanted + noise.draw(noise.group, wanted.shape, rng), rng)


def planned_configurations(
    workspace: Workspace,
    nominal: Mechanism,
    plan: Measurements,
    wedges: np.ndarray | None,
    noise: Noise,
    rng: np.random.Generator,
) -> tuple[np.ndarray, ClosedConfigurations]:
    """Return the group numbers of a plan, and the true closed configurations at the poses that the
    nominal mechanism has at its joints, each turned to its group's inclination (with the noise of
    that). Raises InputError for configurations that cannot be taken.
    """
    model = build_model(nominal, plan, ())
    configurations = solve_configurations(model, plan, model.nominal)
    if not configurations.solved.all():
        label = plan.named(~configurations.solved)[0]
        raise InputError(
            f"the plan's posture of {label} does not close at the nominal geometry of "
            f"{nominal.name}"
        )
    held = None
    if plan.groups is not None:
        if wedges is None:
            raise InputError(
                "the plan has groups and no wedge_alpha and wedge_beta; give the file that `plan` "
                "wrote"
            )
        held = wedges + noise.draw(noise.group, wedges.shape, rng)
    starts = with_poses(workspace.closure, model.poses(configurations.z, plan.joints))
    if workspace.carried:
        starts = workspace.at_joints(plan.joints, starts)
    made, closed = workspace.close(starts, held, limits=False)
    if not closed.all():
        raise InputError(
            f"the plan's posture of {plan.named(~closed)[0]} cannot be taken by "
            f"{workspace.mechanism.name}"
        )
    return plan.group_of, made


def simulate_readings(
    mechanism: Mechanism,
    true: ClosedConfigurations,
    groups: np.ndarray,
    readings: Sequence[str],
    noise: Noise,
    rng: np.random.Generator,
    distances: Mapping[str, tuple[Sequence[float], Sequence[float]]] | None = None,
) -> Measurements:
    """Read true configurations, with standard deviations where there is noise; `readings` are kinds
    of the platform (see `READING_CHOICES`) and names of observables (see `data.observables`),
    `distances` points of the platform and of the base by the names of their columns.
    """
    grouped = bool(np.any(groups != NO_GROUP))
    to_base = [distance_to_base(name, ends) for name, ends in (distances or {}).items()]
    taken = taken_readings(mechanism, readings, grouped=grouped)
    # distances to the base stand before what is not of the platform, as in a file
    read = sorted((*to_base, *taken), key=lambda o: 2 * bool(o.of) + bool(o.ends))
    model = model_of(mechanism, tuple(read))
    values = many_elsewhere(model.closure, build_closure(mechanism), true.values)
    z = np.ascontiguousarray(values[:, true.joints.shape[1] :])
    refuse_undetermined(model, z, true.joints, model.nominal)
    joint_sigma = noise.joints(mechanism)
    made = Measurements(
        true.joints + noise.draw(joint_sigma, true.joints.shape, rng),
        joint_sigma=joint_sigma if joint_sigma.any() else None,
        groups=groups if grouped else None,
        group_sigma=(noise.group or None) if grouped else None,
    )
    beside, ends = list[Reading](), np.cumsum([len(o.columns) for o in read])[:-1]
    (table,) = model.values("exact", z, true.joints, model.nominal)
    for o, exact in zip(read, np.split(table, ends, axis=1), strict=False):
        sigma = noise.of(o.kind, angular=o.angular)
        if o.kind == "orientation":
            exact = exact * np.where(exact[:, :1] < 0, -1.0, 1.0)
            turn = quaternion_from_rotation_vector(noise.draw(sigma, (3, len(exact)), rng))
            exact = multiply(exact.T, turn).T
        else:
            exact = exact + noise.draw(sigma, exact.shape, rng)
        if o.by_name:
            beside.append(Reading(o.key, exact, sigma or None, o.ends))
        else:
            made = made.replaced(o.key, values=exact, sigma=sigma or None)
    return replace(made, readings=beside)


# --- slopes ---------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class PlannedReadings:
    """What would be read of a mechanism, with which noise, and the parameters that it should
    tell.
    """

    mechanism: Mechanism
    readings: Sequence[str]
    noise: Noise
    names: Sequence[str]

    def problem(
        self, made: ClosedConfigurations, groups: np.ndarray
    ) -> tuple[CalibrationProblem, np.ndarray]:
        """State the problem of readings at closed configurations, with the unknown coordinates
        there. Raises InputError where a reading is without a standard deviation.
        """
        m, quiet = self.mechanism, np.random.default_rng(0)
        taken = simulate_readings(m, made, groups, self.readings, self.noise, quiet)
        for o, r in taken.channels(m):
            if r.sigma is None:
                raise InputError(
                    f"the standard deviation of {o.name if o.of else f'{o.name} readings'} is zero "
                    f"or not given; a plan needs it"
                )
        # readings at the configurations themselves
        read = None if taken.orientation is None else made.poses[:, 3:]
        taken = replace(taken, joints=made.joints, orientation=read)
        problem = build_calibration(m, taken, parameters=self.names)
        values = many_elsewhere(problem.model.closure, build_closure(m), made.values)
        return problem, np.ascontiguousarray(values[:, made.joints.shape[1] :])

    def slopes(self, made: ClosedConfigurations, *, grouped: bool) -> tuple[np.ndarray, np.ndarray]:
        """Differentiate the readings at closed configurations, over their standard deviations,
        joint noise included: (n, K, P) by scaled parameters, and (n, K, 2) by the unknown
        inclination of the configuration's group, none where it has none.
        """
        problem, z = self.problem(made, np.full(len(made), 0 if grouped else NO_GROUP))
        p = problem.model.nominal
        found = evaluate_at(problem, p, z).slopes, joint_covariance(problem, p, z)
        # two inclinations have no slopes where the platform's z axis lies level: such a
        # configuration is offered as one that tells nothing
        told = np.all([np.isfinite(v).all(axis=(1, 2)) for v in found], axis=0)
        slopes, of_joints = (np.where(told[:, None, None], v, 0.0) for v in found)
        whiten = whitening(problem.readings, noise_of(problem.readings, of_joints))
        return whiten @ slopes, whiten[:, :, problem.readings.grouped if grouped else []]
