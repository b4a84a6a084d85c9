"""The parameters of a mechanism file that matter: `all`, a set without those that move no pose in any machine of its kind.

A file writes down more than the geometry has: a direction has a length, the point of a joint may lie anywhere on its axis, a slide may
pass anywhere, a passive joint's zero shifts only its own coordinate, and any closed configuration may be the reference, so that the
zeros of actuated joints are told by points and axes there. Of each such freedom one parameter is left out: the largest component. What
is free at the nominal values only, parallel axes for instance, stays: the machine as built may tell it.
"""

from __future__ import annotations

import numpy as np

from symkin.caching import lru_cache
from symkin.calibration.direct import solved_steps
from symkin.calibration.measurements import Measurements
from symkin.calibration.model import build_model
from symkin.calibration.motions import written_freedoms
from symkin.calibration.parameters import bound_by_motion
from symkin.calibration.workspace import Workspace
from symkin.closure.closure import build_closure
from symkin.errors import SymkinError
from symkin.model.mechanism import Mechanism

_POSTURES = 24
"""Random closed configurations at which zeros are compared with the other parameters."""
_TOLD = 1e-7
"""A zero whose effect differs by less than this share from one of the other parameters is told by them."""


@lru_cache(maxsize=64)
def minimal_parameters(mechanism: Mechanism) -> tuple[str, ...]:
    """Names of the closure's parameters, in its order, without those that a declared motion binds and one for each freedom in how the
    file is written."""
    bound, closure = bound_by_motion(mechanism), build_closure(mechanism)
    values = dict(zip(closure.parameter_names, map(float, closure.parameter_values), strict=True))
    dropped: set[str] = set()
    for _, velocity in written_freedoms(mechanism, values):
        open_ = {n: abs(v) for n, v in velocity.items() if n in values and n not in bound and n not in dropped and abs(v) > 1e-12}
        if open_:
            dropped.add(max(open_, key=lambda n: open_[n]))
    kept = [n for n in closure.parameter_names if n not in bound and n not in dropped]
    return tuple(n for n in kept if n not in _told_zeros(mechanism, kept))


def _told_zeros(mechanism: Mechanism, names: list[str]) -> set[str]:
    """Zeros of actuated joints among the names whose effect on closure and pose is that of the other parameters."""
    zeros = [n for n in names if n.endswith(".zero")]
    if not zeros:
        return set()
    try:
        workspace, rng = Workspace.about(mechanism), np.random.default_rng(0)
        made = workspace.draw(workspace.inclinations(_POSTURES, rng), rng, held=False)
    except SymkinError:
        return set()
    poses = Measurements(made.joints, position=made.poses[:, :3], orientation=made.poses[:, 3:])
    model = build_model(mechanism, poses, names)
    z = np.ascontiguousarray(made.values[:, len(mechanism.actuated) :])
    e = model.evaluate(z, made.joints, model.nominal, made.poses[:, 3:])
    follow = solved_steps(e.rows_z, e.rows_p)
    effect = np.concatenate([e.readings_p - e.readings_z @ follow, e.rows_p - e.rows_z @ follow], axis=1).reshape(-1, len(names))
    told, others = set[str](), [k for k, n in enumerate(names) if n not in zeros]
    for zero in zeros:
        column, basis = effect[:, names.index(zero)], effect[:, others]
        left = column - basis @ np.linalg.lstsq(basis, column, rcond=1e-10)[0]
        if np.linalg.norm(left) <= _TOLD * np.linalg.norm(column):
            told.add(zero)
        else:
            others.append(names.index(zero))
    return told
