"""Simulate readings as a measuring system would take them of a mechanism with a known geometry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symkin.calibration.data.measurements import NO_GROUP, Distance, Measurements, Reading
from symkin.calibration.data.observables import (
    Observable,
    observables,
    observables_named,
    unknown_observable,
)
from symkin.calibration.estimate.configuration_model import build_model
from symkin.calibration.estimate.configurations import (
    ClosedConfigurations,
    refuse_undetermined,
    solve_configurations,
)
from symkin.calibration.estimate.workspace import Workspace
from symkin.closure.closure import build_closure
from symkin.closure.link_poses import joint_readings, link_poses
from symkin.errors import InputError
from symkin.model.mechanism import Mechanism
from symkin.position.readings import points_at
from symkin.position.transfer import many_elsewhere
from symkin.spatial.pose import Pose
from symkin.spatial.rotation import euler_from_quaternion, multiply, quaternion_from_rotation_vector

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
        return np.asarray(sigma * unit)

    def joints(self, mechanism: Mechanism) -> np.ndarray:
        """Standard deviation of each actuated joint (a,)."""
        return np.array([self.angles if c.is_angular else self.lengths for c in mechanism.actuated])

    def of(self, kind: str, *, angular: bool = True) -> float:
        """Standard deviation of the readings of a kind; of joints those of angles or lengths."""
        others = {"point": "position", "joint": "angles" if angular else "lengths"}
        return float(getattr(self, others.get(kind, kind)))


def platform_kinds(
    mechanism: Mechanism, readings: Sequence[str], *, grouped: bool = False
) -> tuple[str, ...]:
    """Return which of the readings are of the platform. Raises InputError for what is unknown, and
    for readings and groups (of equal inclination) of a platform that is not there.
    """
    own = tuple(kind for kind in readings if kind in READING_CHOICES)
    if (own or grouped) and mechanism.platform_link is None:
        what = f"readings: {own[0]!r} is read" if own else "groups: equal inclination is that"
        raise InputError(
            f"{what} of a platform, and {mechanism.name} has no platform link; name it by "
            f"[platform] link, or "
            "read named points (point.NAME) and other links (LINK.pose, LINK.position, "
            "LINK.orientation, LINK.inclination)"
        )
    observed_kinds(mechanism, readings)
    return own


def observed_kinds(mechanism: Mechanism, readings: Sequence[str]) -> tuple[Observable, ...]:
    """Return what else is read; a link's pose is its position and its orientation."""
    known, names = observables(mechanism), list[str]()
    for name in readings:
        if name in READING_CHOICES:
            continue
        link, _, last = name.rpartition(".")
        whole = [f"{link}.position", f"{link}.orientation"] if last == "pose" else [name]
        if not all(part in known for part in whole):
            besides = READING_CHOICES if mechanism.platform_link is not None else ()
            raise InputError(f"readings: {unknown_observable(mechanism, name, besides)}")
        names += whole
    return observables_named(mechanism, names)


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
            f"{groups} groups for {configurations} posture{'s' * (configurations != 1)}, and two "
            f"postures in each are needed: at least {2 * groups} "
            f"postures for {groups} group{'s' * (groups != 1)}, or fewer --groups"
        )
    if groups == 0:
        return np.full(configurations, NO_GROUP)
    return np.repeat(
        np.arange(groups), [len(part) for part in np.array_split(np.arange(configurations), groups)]
    )


def random_configurations(
    workspace: Workspace, groups: np.ndarray, noise: Noise, rng: np.random.Generator
) -> ClosedConfigurations:
    """Draw random closed configurations; those of one group share the inclination of its wedge, but
    for the noise of that.
    """
    if np.all(groups == NO_GROUP):
        return workspace.draw(workspace.inclinations(len(groups), rng), rng, held=False)
    wanted = workspace.inclinations(int(groups.max()) + 1, rng)[groups]
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
    configurations = solve_configurations(model, plan, np.zeros(0))
    if not configurations.solved.all():
        label = plan.labels[int(np.argmin(configurations.solved))]
        raise InputError(
            f"the plan's posture of {label} does not close at the nominal geometry of "
            f"{nominal.name}"
        )
    groups = np.full(len(plan), NO_GROUP) if plan.groups is None else plan.groups
    held = None
    if plan.groups is not None:
        if wedges is None:
            raise InputError(
                "the plan has groups and no wedge_alpha and wedge_beta; give the file that `plan` "
                "wrote"
            )
        held = wedges + noise.draw(noise.group, wedges.shape, rng)
    made, closed = workspace.at(
        model.poses(configurations.z, plan.joints, np.zeros(0)), plan.joints, held
    )
    if not closed.all():
        raise InputError(
            f"the plan's posture of {plan.labels[int(np.argmin(closed))]} cannot be taken by "
            f"{workspace.mechanism.name}"
        )
    return groups, made


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
    own = platform_kinds(mechanism, readings, grouped=grouped)
    _refuse_undetermined(mechanism, true)

    def read(kind: str, exact: np.ndarray, sigma: float) -> np.ndarray:
        if kind != "orientation":
            return np.asarray(exact + noise.draw(sigma, exact.shape, rng))
        turn = quaternion_from_rotation_vector(noise.draw(sigma, (3, len(exact)), rng))
        return np.asarray(multiply(exact.T, turn)).T

    joint_sigma = noise.joints(mechanism)
    changes: dict[str, Any] = {
        "joints": true.joints + noise.draw(joint_sigma, true.joints.shape, rng),
        "joint_sigma": joint_sigma if np.any(joint_sigma) else None,
    }
    if grouped:
        changes |= {"groups": groups, "group_sigma": noise.group or None}
    alpha, beta, _ = euler_from_quaternion(true.poses[:, 3:].T, "xyz")
    platform = {
        "inclination": np.column_stack([alpha, beta]),
        "position": true.poses[:, :3],
        "orientation": true.poses[:, 3:],
    }
    for kind, exact in platform.items():
        if kind in own or ("pose" in own and kind != "inclination"):
            sigma = noise.of(kind)
            changes |= {kind: read(kind, exact, sigma), f"{kind}_sigma": sigma or None}
    measured = []
    for name, (end, base) in (distances or {}).items():
        ends = np.array([Pose(row[:3], row[3:]).apply(np.array(end)) for row in true.poses])
        values = read("distance", np.linalg.norm(ends - np.array(base), axis=1), noise.distance)
        measured.append(Distance(end, base, values, noise.distance or None, name))
    others = observed_kinds(mechanism, readings)
    exactly = exact_readings(mechanism, true, others) if others else {}
    beside = []
    for o in others:
        sigma = noise.of(o.kind, angular=o.angular)
        beside.append(Reading(o.name, read(o.kind, exactly[o.name], sigma), sigma or None))
    return Measurements(**changes, distances=measured, readings=beside)


def _refuse_undetermined(mechanism: Mechanism, true: ClosedConfigurations) -> None:
    """Refuse, as a fit would, joints that do not determine the configuration."""
    model = build_model(mechanism, Measurements(true.joints), ())
    values = many_elsewhere(model.closure, build_closure(mechanism), true.values)
    z = np.ascontiguousarray(values[:, true.joints.shape[1] :])
    refuse_undetermined(model, z, true.joints, model.nominal)


def exact_readings(
    mechanism: Mechanism, true: ClosedConfigurations, read: Sequence[Observable]
) -> dict[str, np.ndarray]:
    """Values (n, w) of observables by name at closed configurations."""
    closure = build_closure(mechanism)
    poses = link_poses(closure, true.values)
    joints, points = joint_readings(closure, poses), points_at(mechanism, poses)
    found = {}
    for o in read:
        match o.kind:
            case "joint":
                held = (
                    true.values[:, closure.slices[o.name]]
                    if o.name in closure.slices
                    else joints[o.name][:, None]
                )
                found[o.name] = np.asarray(held)
            case "point":
                found[o.name] = points[o.of[0]]
            case "distance":
                found[o.name] = np.linalg.norm(points[o.of[0]] - points[o.of[1]], axis=1)[:, None]
            case "position":
                found[o.name] = np.asarray(poses[o.of[0]].position).T
            case "orientation":
                found[o.name] = np.asarray(poses[o.of[0]].quaternion).T
            case _:
                alpha, beta, _ = euler_from_quaternion(poses[o.of[0]].quaternion, "xyz")
                found[o.name] = np.column_stack([alpha, beta])
    return found
