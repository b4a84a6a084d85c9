"""symkin: kinematics of robots with closed loops, from one description.

    import symkin

    platform = symkin.load("platform.toml")
    print(symkin.modes(platform, joints=[100.0, 120.0, 110.0]))

Verbs: `load`, `shipped_names`, `close`, `convert`; `modes`, `solve`; `mobility`, `jacobian`,
`singularity`, `singular_loci`; `track`, `mode_graph`, `sweep`; `transmission`; `calibrate`,
`plan_measurements`; `write_firmware`; `view`. Each returns a result that prints its table, has a
short repr, HTML for notebooks, `to_dict()` (the JSON of the command line) and `plot()`.
docs/architecture.md says where what is done.
"""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from symkin._version import __version__
from symkin.errors import InputError, MechanismError, SymkinError
from symkin.result import Result, draw_with, view_with

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from symkin.assembly.modes import modes
    from symkin.assembly.modes_result import Modes
    from symkin.calibration.calibrate import calibrate
    from symkin.calibration.data.measurements import Measurements, Reading
    from symkin.calibration.design.planning import plan_measurements
    from symkin.calibration.judge.result import Calibration
    from symkin.codegen.folder.folder import write_firmware
    from symkin.following.mode_graph import ModeGraph, mode_graph
    from symkin.following.track import track
    from symkin.following.track_result import Track
    from symkin.formats.load import load
    from symkin.formats.read_options import ReadOptions
    from symkin.model.description import Example
    from symkin.model.dh import DHRow, DHTable
    from symkin.model.graph import Coupling, LinkJoint, LinkPoint, LinkRod
    from symkin.model.joint import Joint
    from symkin.model.limb import Limb, Rod, RodLimb
    from symkin.model.mechanism import Mechanism, serial_arm_from_dh
    from symkin.model.motor import Motor as Motor
    from symkin.model.shipped import shipped_names
    from symkin.page.result_views import view
    from symkin.position.close import close
    from symkin.position.close_result import ClosedConfiguration
    from symkin.position.convert import convert
    from symkin.position.least_squares import LeastSquares as LeastSquares
    from symkin.position.mobility import mobility
    from symkin.position.mobility_result import Mobility
    from symkin.position.newton import Newton as Newton
    from symkin.position.solution import Solution
    from symkin.position.solve import solve
    from symkin.position.solve_result import SolveError, SolveResult
    from symkin.singularities.classification import singularity
    from symkin.singularities.loci import Loci
    from symkin.singularities.singular_loci import singular_loci
    from symkin.singularities.singularity_result import Singularity
    from symkin.spatial.pose import Pose
    from symkin.sweeps.run import sweep
    from symkin.transmissions.transmission import transmission
    from symkin.transmissions.transmission_result import Transmission as Transmission
    from symkin.transmissions.transmission_result import Transmissions as Transmissions
    from symkin.velocity.jacobian import Jacobian, jacobian

__all__ = [
    "Calibration",
    "ClosedConfiguration",
    "Coupling",
    "DHRow",
    "DHTable",
    "Example",
    "InputError",
    "Jacobian",
    "Joint",
    "Limb",
    "LinkJoint",
    "LinkPoint",
    "LinkRod",
    "Loci",
    "Measurements",
    "Mechanism",
    "MechanismError",
    "Mobility",
    "ModeGraph",
    "Modes",
    "Pose",
    "ReadOptions",
    "Reading",
    "Rod",
    "RodLimb",
    "Singularity",
    "Solution",
    "SolveError",
    "SolveResult",
    "SymkinError",
    "Track",
    "__version__",
    "calibrate",
    "close",
    "convert",
    "jacobian",
    "load",
    "mobility",
    "mode_graph",
    "modes",
    "plan_measurements",
    "serial_arm_from_dh",
    "shipped_names",
    "singular_loci",
    "singularity",
    "solve",
    "sweep",
    "track",
    "transmission",
    "view",
    "write_firmware",
]

_LATER = {
    "Calibration": "symkin.calibration.judge.result",
    "ClosedConfiguration": "symkin.position.close_result",
    "Coupling": "symkin.model.graph",
    "DHRow": "symkin.model.dh",
    "DHTable": "symkin.model.dh",
    "Example": "symkin.model.mechanism",
    "Jacobian": "symkin.velocity.jacobian",
    "Joint": "symkin.model.joint",
    "LeastSquares": "symkin.position.least_squares",
    "Limb": "symkin.model.limb",
    "LinkJoint": "symkin.model.graph",
    "LinkPoint": "symkin.model.graph",
    "LinkRod": "symkin.model.graph",
    "Loci": "symkin.singularities.loci",
    "Measurements": "symkin.calibration.data.measurements",
    "Mechanism": "symkin.model.mechanism",
    "Motor": "symkin.model.motor",
    "Mobility": "symkin.position.mobility_result",
    "ModeGraph": "symkin.following.mode_graph",
    "Modes": "symkin.assembly.modes_result",
    "Newton": "symkin.position.newton",
    "Pose": "symkin.spatial.pose",
    "ReadOptions": "symkin.formats.read_options",
    "Reading": "symkin.calibration.data.measurements",
    "Rod": "symkin.model.limb",
    "RodLimb": "symkin.model.limb",
    "Singularity": "symkin.singularities.singularity_result",
    "Solution": "symkin.position.solution",
    "SolveError": "symkin.position.solve_result",
    "SolveResult": "symkin.position.solve_result",
    "Track": "symkin.following.track_result",
    "Transmission": "symkin.transmissions.transmission_result",
    "Transmissions": "symkin.transmissions.transmission_result",
    "calibrate": "symkin.calibration.calibrate",
    "close": "symkin.position.close",
    "convert": "symkin.position.convert",
    "jacobian": "symkin.velocity.jacobian",
    "load": "symkin.formats.load",
    "mobility": "symkin.position.mobility",
    "mode_graph": "symkin.following.mode_graph",
    "modes": "symkin.assembly.modes",
    "plan_measurements": "symkin.calibration.design.planning",
    "serial_arm_from_dh": "symkin.model.mechanism",
    "shipped_names": "symkin.model.shipped",
    "singular_loci": "symkin.singularities.singular_loci",
    "singularity": "symkin.singularities.classification",
    "solve": "symkin.position.solve",
    "sweep": "symkin.sweeps.run",
    "track": "symkin.following.track",
    "transmission": "symkin.transmissions.transmission",
    "view": "symkin.page.result_views",
    "write_firmware": "symkin.codegen.folder.folder",
}
"""Modules that are imported at the first use of a name, since no run needs them all, and a command
hears Ctrl-C before the first of them. `Newton` and
`LeastSquares` are values of `solver=` with settings of one's own; their names ("newton", "ipopt")
suffice, so that they are not listed, and no more are results of `transmission`, which nobody makes.
"""


def __getattr__(name: str) -> object:
    if name in _LATER:
        return globals().setdefault(name, getattr(import_module(_LATER[name]), name))
    raise AttributeError(f"module 'symkin' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)


def _draw(result: Result, path: Path | str | None = None, **options: Any) -> "Figure":
    """Draw a result. Only here, above all packages, do results and `symkin.plots` meet: see
    `symkin.result`.
    """
    from symkin.plots.pictures import draw

    return draw(result, path, **options)


def _view(result: Result, **options: Any) -> Any:
    from symkin.page.result_views import view

    return view(result, **options)


draw_with(_draw)
view_with(_view)
