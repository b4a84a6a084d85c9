"""Rows that branches imply without their passive joints, and the parts into which they take a
block.
"""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.gate import in_gate
from helpers.graph_twin import graph_twin
from helpers.inside import (
    HomogeneousPose,
    ProductRow,
    StudyPose,
    build_problem,
    closed_configurations,
    implied_parts,
    multiply,
    problem_of,
    read_given,
    structure_groups,
)
from helpers.moved_points import three_upu
from helpers.samples import rus, three_rps, three_rrr
from helpers.samples import tricept_of_joints as tricept
from helpers.spellings import three_ruu
from symkin import Joint, Limb, Mechanism, RodLimb

Z = (0.0, 0.0, 1.0)


def agile_eye() -> Mechanism:
    """Three limbs of three revolutes whose axes meet at the origin, square to each other at the
    reference.
    """
    x, y, z = np.eye(3)
    limbs = []
    for k, (a, b, c) in enumerate([(x, y, -z), (y, z, -x), (z, x, -y)]):
        axes = {"m": a, "e": b, "p": c}
        joints = [Joint(f"{n}{k}", "R", 60 * v, v, actuated=n == "m") for n, v in axes.items()]
        limbs.append(Limb(f"l{k}", joints))
    return Mechanism("agile", limbs)


def level_platform(link: float) -> Mechanism:
    """Three limbs, each a vertical revolute, three level ones and a vertical one, and a rod: links
    so long that the platform can also lie on its face.
    """
    limbs: list[Limb | RodLimb] = []
    for k, turn in enumerate(np.radians([-90.0, 30.0, 150.0])):
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        level, foot, head = np.cross(Z, out), 138.0 * out, 69.0 * out + [0, 0, 100.0]
        reach = np.linalg.norm(head - foot)
        aside = np.cross(level, (head - foot) / reach)
        elbow = (foot + head) / 2 + np.sqrt(link**2 - reach**2 / 4) * aside
        joints = [Joint(f"m{k}", "R", foot, Z, actuated=True)]
        joints += [
            Joint(f"{n}{k}", "R", p, level) for n, p in (("h", foot), ("e", elbow), ("w", head))
        ]
        limbs.append(Limb(f"l{k}", [*joints, Joint(f"t{k}", "R", head, Z)]))
    limbs.append(RodLimb("op", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    return Mechanism("level", limbs, platform_position=(0.0, 0.0, 100.0))


def group_of(mechanism: Mechanism):
    """The largest structure group of the direct problem at the reference."""
    problem = problem_of(mechanism, read_given(mechanism))
    return max(structure_groups(problem), key=lambda group: group.system.freedom)


MACHINES = {
    "3-RRR": lambda: three_rrr("planar"),
    "3-RRR graph": lambda: graph_twin(three_rrr()),
    "3-RPS": three_rps,
    "agile": agile_eye,
    "agile graph": lambda: graph_twin(agile_eye()),
    "tricept": lambda: tricept(False),
    "tricept of revolutes": lambda: tricept(True),
    "6-RUS": lambda: rus(6),
    "level graph": lambda: graph_twin(level_platform(220.0)),
    "3-UPU": three_upu,
    "3-RUU": lambda: replace(three_ruu(), motion="spatial"),
}


GATE = ["3-RRR", "agile graph", "tricept", "3-RUU"]


@pytest.mark.parametrize("name", in_gate(list(MACHINES), GATE))
def test_implied_rows_hold_wherever_the_closure_does(name):
    """They vanish at closed configurations to rounding, and hold no joint that a later part finds;
    the parts' unknowns are those of the group, each once.
    """
    group = group_of(MACHINES[name]())
    parts, closure = implied_parts(group), group.closure
    assert len(parts) > 1
    assert sum(len(part.implied) for part in parts) > 0
    assert sorted(c.name for part in parts for c in part.system.unknowns) == sorted(
        c.name for c in group.system.unknowns
    )
    found: set[str] = {c.name for c in group.known_coordinates}
    for part in parts:
        assert {c.name for c in part.known_coordinates} <= found
        found |= {c.name for c in part.system.unknowns}
        for values in closed_configurations(closure, 5):
            rows, _ = part.system.linearise_one(
                values[part.unknown_places], values[part.known_places]
            )
            assert np.max(np.abs(rows), initial=0.0) < 1e-9 * closure.characteristic_length


@pytest.mark.parametrize("name", ["3-RPS", "6-RUS", "agile", "3-UPU", "3-RUU"])
def test_implied_rows_of_a_body_are_the_same_in_every_form_of_its_pose(name):
    """In Study coordinates, or of a quaternion of any length, each is the row times the weight, one
    that multiplies two places of the body times its square.
    """
    problem = group_of(MACHINES[name]())
    closure, rng = problem.closure, np.random.default_rng(1)
    names = [*(f"pose.{axis}" for axis in "xyz"), "pose.quaternion"]
    place, turn = (
        ca.vertcat(*(closure.variables[closure.slices[n]] for n in part))
        for part in (names[:3], names[3:])
    )
    e, g = ca.SX.sym("e", 4), ca.SX.sym("g", 4)
    for part in implied_parts(problem):
        for row in part.implied:
            values = rng.normal(size=closure.variables.shape[0])
            q, p, scale = rng.normal(size=4), rng.normal(size=3), rng.uniform(0.5, 2.0)
            q /= np.linalg.norm(q)
            at = values.copy()
            at[closure.slices["pose.quaternion"]] = q
            for k, axis in enumerate("xyz"):
                at[closure.slices[f"pose.{axis}"]] = p[k]
            plain = float(ca.Function("f", [closure.variables], [row.row])(at))
            dual = 0.5 * scale * np.asarray(multiply(np.array([0.0, *p]), q))
            for pose in (StudyPose(e, g), HomogeneousPose(ca.SX(ca.DM(p)), e)):
                shown = row.weighted(place, turn, pose)
                other = ca.Function("f", [closure.variables, e, g], [shown])
                weighted = float(other(at, scale * q, dual))
                weight = scale**4 if isinstance(row, ProductRow) else scale**2
                assert weighted == pytest.approx(weight * plain, rel=1e-9, abs=1e-9)


# --- one machine, however it is written -----------------------------------------------------------


SPELLINGS = {
    "agile": (8, lambda: [agile_eye(), replace(agile_eye(), motion="spherical")]),
    "tricept": (192, lambda: [tricept(False), tricept(True)]),
    "6-RUS": (40 * 2**6, lambda: [rus(6)]),
    "3-UPU": (78 * 2**3, lambda: [three_upu()]),
    "3-RUU": (84 * 2**3, lambda: [replace(three_ruu(), motion="spatial")]),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", in_gate(SPELLINGS, ["agile", "3-RUU", "6-RUS"]))
def test_a_machine_has_the_same_modes_however_it_is_written(name):
    """Limbs, a graph, a declared motion, a U as two revolutes: the same count of complex solutions,
    no path lost, the same poses; and every real one that random starts find.
    """
    count, machines = SPELLINGS[name]
    machines = machines()
    machines += [graph_twin(machine) for machine in machines]
    rng = np.random.default_rng(2)
    reference = np.array([c.reference[0] for c in machines[0].actuated])
    angles = [c.is_angular for c in machines[0].actuated]
    joints = reference + rng.uniform(-1.0, 1.0, len(angles)) * np.where(angles, 0.3, 12.0)
    joints = np.where(angles, np.degrees(joints), joints)
    poses = []
    for machine in machines:
        found = symkin.modes(machine, joints=joints.tolist())
        assert (found.completeness, found.complex_count) == ("probability one", count)
        assert all(m.residual < 1e-10 * machine.characteristic_length for m in found)
        poses.append(sorted(_plain_pose(mode.pose) for mode in found))
    for other in poses[1:]:
        np.testing.assert_allclose(other, poses[0], atol=1e-6)
    sampled = symkin.modes(machines[0], joints=joints.tolist(), method="multistart", starts=400)
    known = np.array(poses[0])
    for mode in sampled:
        assert np.min(np.max(np.abs(known - _plain_pose(mode.pose)), axis=1)) < 1e-5


def _plain_pose(pose) -> tuple[float, ...]:
    """Numbers that do not depend on the quaternion's sign, rounded so that they sort alike."""
    q = np.asarray(pose.quaternion)
    return tuple(np.round([*pose.position, *np.outer(q, q)[np.triu_indices(4)]], 7).tolist())


def test_the_leg_of_a_three_upu_lies_in_the_plane_of_its_outer_axes():
    """(b x w) . a = 0 but for a factor: the only row of each limb beside its sphere."""
    machine, rng = three_upu(), np.random.default_rng(0)
    group = group_of(machine)
    slices, variables = group.closure.slices, group.closure.variables
    (pose, *_) = implied_parts(group)
    products = [row for row in pose.implied if isinstance(row, ProductRow)]
    assert (len(products), len(pose.implied)) == (3, 6)
    rows = ca.Function("f", [variables], [ca.vertcat(*(row.row for row in products))])
    ratios = []
    for _ in range(3):
        values, q = rng.normal(size=int(variables.shape[0])), rng.normal(size=4)
        values[slices["pose.quaternion"]] = q / np.linalg.norm(q)
        position = np.concatenate([values[slices[f"pose.{c}"]] for c in "xyz"])
        rotation = np.asarray(symkin.Pose((0, 0, 0), q / np.linalg.norm(q)).matrix)[:3, :3]
        wanted = []
        for limb in machine.limbs:
            foot, axis, head = (
                np.array(n)
                for n in (limb.joints[0].point, limb.joints[0].axis, limb.joints[2].point)
            )
            w = position + rotation @ (head - np.array(machine.platform_position)) - foot
            wanted.append(np.cross(axis, w) @ (rotation @ axis))
        ratios.append(np.asarray(rows(values)).ravel() / np.array(wanted))
    np.testing.assert_allclose(ratios[1:], [ratios[0]] * 2, rtol=1e-7)


@pytest.mark.slow
@pytest.mark.long
def test_a_platform_that_can_lie_on_its_face_has_these_modes_too():
    """Level limbs keep its normal up or down: 4 poses of either, by two places of each of three
    elbows. Random starts find both kinds.
    """
    machine = level_platform(220.0)
    joints = [90.0, 20.0, -60.0, 220.0]
    expected = symkin.modes(machine, joints=joints, method="multistart", starts=6000)
    for spelling in (machine, graph_twin(machine)):
        found = symkin.modes(spelling, joints=joints)
        assert (found.completeness, found.complex_count) == ("probability one", 64)
        assert len(found) == len(expected)
        assert {_is_upright(mode) for mode in found} == {_is_upright(mode) for mode in expected}


def _is_upright(mode) -> bool:
    _, x, y, _ = mode.pose.quaternion
    return x * x + y * y < 0.5


def test_a_certified_mode_is_so_of_all_rows_of_its_block():
    """Parts say nothing of certificates: modes of parts are proved in the block's own rows."""
    found = symkin.modes(graph_twin(tricept(False)))
    assert found.complex_count == 192
    assert all(mode.certified and mode.radius < 1e-9 for mode in found)


def test_more_combinations_than_are_listed_are_refused(monkeypatch):
    """The parts' solutions are multiplied only as far as shows that they are too many."""
    for module in (inside.tree, inside.by_groups):
        monkeypatch.setattr(module, "MOST_MODES", 10)
    with pytest.raises(symkin.SymkinError, match="10 modes that are listed"):
        symkin.modes(graph_twin(tricept(False)))


def test_where_no_mode_is_real_the_parts_are_counted_and_the_least_error_is_told():
    """A slide too short for its limb: no mode, all complex solutions, an error above rounding."""
    machine = graph_twin(tricept(False))
    found = symkin.modes(machine, joints=[20.0, 300.0, 300.0])
    assert len(found) == 0
    assert (found.completeness, found.complex_count) == ("probability one", 192)
    assert found.smallest_residual > 1.0


def test_build_problem_without_passive_joints_has_no_parts():
    """Rods alone imply nothing."""
    problem = build_problem(symkin.load("zhang2009"), "direct")
    assert implied_parts(problem) == ()
