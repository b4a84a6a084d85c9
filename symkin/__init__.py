"""symkin: kinematics of robots with closed loops, from one description.

import symkin
platform = symkin.load("platform.toml")
print(symkin.modes(platform, joints=[100.0, 120.0, 110.0]))
"""

from symkin._version import __version__
from symkin.enumeration.modes import modes
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

__all__ = [
    "DHRow",
    "DHTable",
    "Example",
    "InputError",
    "Joint",
    "LeastSquares",
    "Limb",
    "Mechanism",
    "MechanismError",
    "Newton",
    "Pose",
    "Rod",
    "RodLimb",
    "SolveError",
    "SymkinError",
    "__version__",
    "load",
    "modes",
    "serial_arm_from_dh",
    "shipped_names",
    "solve",
]
