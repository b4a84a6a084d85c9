"""Choose the tree of a robot's joints that places all links at the file's own configuration; the
other joints close loops.

The tree takes fixed joints first, then those that no closure says as well (screws, universal
joints, coupled ones), then those with a range or a motor, then the others in the file's order;
joints that the file writes as closures come last, and join the tree only where nothing else
reaches.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import casadi as ca

from symkin.closure.chain import Chain, JointSymbols, displacement_steps
from symkin.closure.parameters import ParameterTable
from symkin.closure.rows import Cut, rows_of_joint
from symkin.errors import MechanismError
from symkin.formats.naming import allowed_names, fresh_name, renamed
from symkin.formats.robot import Robot, RobotJoint, joint_at
from symkin.model.graph import Coupling
from symkin.model.joined import outward, spanning
from symkin.model.joint import BASE
from symkin.text import first_of

_COINCIDE = 1e-6
"""Metres and radians: frames that are this near are one to the digits that files hold."""
_EXCHANGED = {"1": "2", "2": "1"}
"""Coordinates of a universal joint that the mechanism has from its other link."""


def spanned(robot: Robot) -> Robot:
    """The robot with its tree, its root as "base", under names that mechanisms may have; what the
    root does not reach is left out.
    """
    robot = uniquely_named(robot)
    bodies, joints = names_of(robot)
    roots = [robot.root, *robot.floating]
    tree = spanning_tree(robot.told, robot.couplings, roots)
    inside = [joint for joint, _ in outward(tree, roots)]
    reached = dict.fromkeys([*roots, *(body for joint in inside for body in joint.links)])
    placing, moving = {j.name for j in inside}, {j.name for j in inside if j.type != "weld"}
    rest = [j for j in robot.told if j.links[0] in reached and j.name not in placing]
    coupled = [c for c in robot.couplings if _is_held(c, moving)]
    found = replace(
        robot,
        bodies=[bodies[body] for body in reached],
        root=BASE,
        told=[
            replace(
                j,
                name=joints[j.name],
                links=(bodies[j.links[0]], bodies[j.links[1]]),
                closing=j.name not in placing,
            )
            for j in (*inside, *rest)
        ],
        couplings=[c.renamed(_coordinates(c, joints, robot.parts.turned)) for c in coupled],
        meshes={bodies[b]: own for b, own in robot.meshes.items() if own and b in reached},
        floating={bodies[body]: pose for body, pose in robot.floating.items()},
    )
    within = {j.name: note for j in found.told if j.closing and (note := _within_a_link(found, j))}
    below = {body: bodies[body] for body in reached if body != robot.root}
    named = {old: joints[old] for old in joints if old in moving | {j.name for j in rest}}
    lost = [body for body in robot.bodies if body not in reached]
    held = f"the root link {robot.root!r} is held, as the link {BASE!r}"
    notes = (
        *([held] if robot.root not in ("", BASE) else []),
        *renamed("links", below),
        *renamed("joints", named),
        *robot.notes,
        *([f"nothing joins to the robot, and left out: {first_of(lost)}"] if lost else []),
        *within.values(),
        *(
            f"the coupling of {c.joint!r} is left out: not all of its joints move links of the "
            f"robot"
            for c in robot.couplings
            if c not in coupled
        ),
    )
    return replace(found, told=[j for j in found.told if j.name not in within], notes=notes)


def names_of(robot: Robot) -> tuple[dict[str, str], dict[str, str]]:
    """The names that mechanisms may have for those of bodies and joints in the file."""
    bodies = allowed_names((body for body in robot.bodies if body != robot.root), taken=[BASE])
    return {robot.root: BASE, **bodies}, allowed_names(joint.name for joint in robot.told)


def uniquely_named(robot: Robot) -> Robot:
    """The robot with a number behind the name of a closing joint that another joint has, and with
    all bodies that joints name. Raises MechanismError for two other joints of one name.
    """
    used = {joint.name for joint in robot.told if not joint.closing}
    joints, seen = [], set()
    for joint in robot.told:
        name = fresh_name(joint.name, used) if joint.closing else joint.name
        if name in seen:
            raise MechanismError(
                f"{joint.where}: two joints are named {name!r}; names must be unique in the file"
            )
        seen.add(name)
        joints.append(replace(joint, name=name))
    bodies = dict.fromkeys([*robot.bodies, *(body for j in joints for body in j.links)])
    return replace(robot, bodies=[*bodies], told=joints)


def spanning_tree(
    joints: Sequence[RobotJoint],
    couplings: Sequence[Coupling] = (),
    together: Sequence[str] = (),
) -> list[RobotJoint]:
    """The joints that place every link that they reach, each once (Kruskal's choice in the order of
    preference); links that are `together` are placed already.
    """
    coupled = {name for c in couplings for name in (c.joint, *c.names)}
    coupled |= {name.partition(".")[0] for name in coupled}
    return spanning(joints, lambda joint: _preference(joint, joint.name in coupled), together)


def _preference(joint: RobotJoint, coupled: bool) -> int:
    if joint.closing:
        return 4
    if joint.type == "weld":
        return 0
    if coupled or joint.type in ("H", "U"):
        return 1
    return 2 if joint.limits is not None or joint.actuated else 3


def _is_held(coupling: Coupling, moving: Collection[str]) -> bool:
    """Whether all joints of a coupling are among those that move links."""
    names = (coupling.joint, *coupling.names)
    return all(name in moving or name.rpartition(".")[0] in moving for name in names)


def _coordinates(
    coupling: Coupling, joints: Mapping[str, str], turned: Collection[str]
) -> dict[str, str]:
    """The coordinates of a coupling under their joints' new names."""
    found = {}
    for name in (coupling.joint, *coupling.names):
        stem, dot, ending = name.rpartition(".")
        if stem in turned:
            ending = _EXCHANGED.get(ending, ending)
        found[name] = joints[name] if name in joints else f"{joints[stem]}{dot}{ending}"
    return found


def _within_a_link(robot: Robot, joint: RobotJoint) -> str | None:
    """A note on a closure between two parts of one link, which moves nothing; None for others.
    Raises MechanismError where it cannot close.
    """
    link, other = (robot.part_of[body] for body in joint.links)
    if link != other:
        return None
    first, second = robot.ends_of(joint)
    made = joint_at(first, joint.name, joint.type, pitch=joint.pitch)
    cut = Cut.of(JointSymbols.declare(made, made.name, ParameterTable(bound=True)))
    gap = Chain(displacement_steps(second @ first.inverse()))
    found = rows_of_joint(cut, Chain(()), gap, ca.SX(1))
    errors = ca.vertcat(*(error for _, _, own in found for error in own))
    open_by = float(ca.norm_2(ca.evalf(errors)))
    if open_by > _COINCIDE:
        raise MechanismError(
            f"{joint.where}: it closes a loop within the one link {link!r}, whose two frames are "
            f"{open_by:.3g} apart (m, rad); no configuration closes it"
        )
    return f"the closure {joint.name!r} is within the one link {link!r}, closed, and left out"
