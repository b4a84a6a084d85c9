"""symkin: kinematics of robots with closed loops, from one description.

import symkin
platform = symkin.load("platform.toml")
print(symkin.modes(platform, joints=[100.0, 120.0, 110.0]))
"""

from importlib import import_module
from typing import TYPE_CHECKING

from symkin._version import __version__
from symkin.assembly.modes import modes
from symkin.errors import InputError, MechanismError, SolveError, SymkinError
from symkin.model.dh import DHRow, DHTable
from symkin.model.file import load, shipped_names
from symkin.model.joint import Joint
from symkin.model.limb import Limb, Rod, RodLimb
from symkin.model.mechanism import Example, Mechanism, serial_arm_from_dh
from symkin.position.least_squares import LeastSquares
from symkin.position.newton import Newton
from symkin.position.solve import solve
from symkin.spatial.pose import Pose

if TYPE_CHECKING:
    from symkin.calibration.calibrate import calibrate
    from symkin.calibration.measurements import Measurements
    from symkin.following.track import track
    from symkin.singularities.classification import singularity
    from symkin.sweeps.run import sweep
    from symkin.velocity.jacobian import jacobian

__all__ = [
    "DHRow",
    "DHTable",
    "Example",
    "InputError",
    "Joint",
    "LeastSquares",
    "Limb",
    "Measurements",
    "Mechanism",
    "MechanismError",
    "Newton",
    "Pose",
    "Rod",
    "RodLimb",
    "SolveError",
    "SymkinError",
    "__version__",
    "calibrate",
    "jacobian",
    "load",
    "modes",
    "serial_arm_from_dh",
    "shipped_names",
    "singularity",
    "solve",
    "sweep",
    "track",
]

_LATER = {
    "Measurements": "symkin.calibration.measurements",
    "calibrate": "symkin.calibration.calibrate",
    "jacobian": "symkin.velocity.jacobian",
    "singularity": "symkin.singularities.classification",
    "sweep": "symkin.sweeps.run",
    "track": "symkin.following.track",
}
"""Names whose modules are imported at their first use, since most runs do not need them."""


def __getattr__(name: str) -> object:
    if name in _LATER:
        return getattr(import_module(_LATER[name]), name)
    raise AttributeError(f"module 'symkin' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(set(globals()) | set(__all__))
