"""Put configurations into the variables of another closure of the same mechanism, which holds other joints."""

from __future__ import annotations

import numpy as np

from symkin.closure.closure import Closure
from symkin.closure.link_poses import LinkPoses, joint_readings, link_poses
from symkin.model.joint import Coordinate
from symkin.position.given import pose_coordinates
from symkin.spatial.pose import Pose


def variables_in(closure: Closure, other: Closure, values: np.ndarray) -> np.ndarray:
    """The variables (n, width) of a closure at configurations (n, width) of another, at the nominal geometry."""
    if closure.partition == other.partition:
        return values
    poses = link_poses(other, values)
    read = joint_readings(other, poses)
    found = np.tile(closure.reference, (len(values), 1))
    for c in closure.coordinates:
        place = closure.slices[c.name]
        if c.name in other.slices:
            found[:, place] = values[:, other.slices[c.name]]
        elif c.role == "body":
            found[:, place] = _of_body(closure, poses, c)
        elif c.role != "pose":
            found[:, place] = np.atleast_2d(read[c.name]).T
    role = closure.role("pose")
    if role and role[0].name not in other.slices:
        begin, mechanism = closure.slices[role[0].name].start, closure.mechanism
        platform = poses[mechanism.platform_link or ""]
        for k in range(len(values)):
            pose = Pose(platform.position[:, k], platform.quaternion[:, k]) @ mechanism.reference_pose
            numbers, _ = pose_coordinates(mechanism, pose)
            found[k, begin : begin + len(numbers)] = numbers
    return found


def _of_body(closure: Closure, poses: LinkPoses, coordinate: Coordinate) -> np.ndarray:
    """A floating body's coordinate (n, width): of its turn, or of where its middle has gone."""
    body, key = coordinate.name.rsplit(".", 1)
    if key == "quaternion":
        return np.asarray(poses[body].quaternion).T
    middle = np.array([closure.reference[closure.slices[f"{body}.{axis}"]][0] for axis in "xyz"])
    place: np.ndarray = np.asarray(poses[body].apply(middle[:, None]))[["xyz".index(key)]]
    return place.T
