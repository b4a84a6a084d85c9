"""Every verb in N threads at once: `python thread_work.py N FOLDER` writes what the threads found
to FOLDER/found.json.

The threads start each verb together, on one mechanism that all share and on another one. Verbs that
take long are run by two threads, while the others solve. With N = 1 all is computed in turn: what
the others have to find.
"""

from __future__ import annotations

import hashlib
import json
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import symkin
from helpers.inside import Options, describe, picture, residual_figure, write_folder
from symkin import Measurements, singular_loci

Verb = Callable[[symkin.Mechanism, Path], Any]
THREADS = 8
_JOINTS = (10.0, -10.0)


def make_machine(number: int) -> symkin.Mechanism:
    """A planar five-bar with cranks of its own length, a rotated platform on the right limb."""
    z, length = (0, 0, 1), 100.0 + number
    left = symkin.Limb(
        "left",
        [
            symkin.Joint("crank1", "R", point=(-75, 0, 0), axis=z, actuated=True),
            symkin.Joint("elbow1", "R", point=(-75, length, 0), axis=z),
        ],
    )
    right = symkin.Limb(
        "right",
        [
            symkin.Joint("crank2", "R", point=(75, 0, 0), axis=z, actuated=True),
            symkin.Joint("elbow2", "R", point=(75, 100, 0), axis=z),
            symkin.Joint("tip", "R", point=(0, 230, 0), axis=z),
        ],
    )
    return symkin.Mechanism(
        f"five_bar{number}",
        [left, right],
        platform_position=(0, 230, 0),
        motion="planar",
        angle_unit="deg",
    )


def load(machine: symkin.Mechanism, folder: Path) -> Any:
    path = folder / f"{machine.name}.toml"
    path.write_text(machine.to_toml())
    return [symkin.load(path) == machine, symkin.load("zhang2009").name]


def modes_direct(machine: symkin.Mechanism, folder: Path) -> Any:
    found = symkin.modes(machine, joints=_JOINTS)
    return [found.completeness, [(m.position, m.certified, m.radius) for m in found]]


def modes_inverse(machine: symkin.Mechanism, folder: Path) -> Any:
    pose = symkin.solve(machine, joints=_JOINTS).solution.pose
    found = symkin.modes(machine, pose=pose)
    return [found.completeness, [(sorted(m.joints.items()), m.certified) for m in found]]


def modes_sampled(machine: symkin.Mechanism, folder: Path) -> Any:
    return [
        m.position for m in symkin.modes(machine, joints=_JOINTS, method="multistart", starts=50)
    ]


def newton(machine: symkin.Mechanism, folder: Path) -> Any:
    results = [symkin.solve(machine, joints=(10.0 + k, -10.0)) for k in range(10)]
    return [(r.solution.position, r.iterations) for r in results]


def ipopt(machine: symkin.Mechanism, folder: Path) -> Any:
    results = [symkin.solve(machine, joints=(10.0 + k, -10.0), solver="ipopt") for k in range(4)]
    return [(r.solution.position, r.iterations) for r in results]


def jacobian(machine: symkin.Mechanism, folder: Path) -> Any:
    solution = symkin.solve(machine, joints=_JOINTS).solution
    return [
        symkin.jacobian(machine, kind).at(solution).tolist()
        for kind in ("direct", "inverse", "passive")
    ]


def singularity(machine: symkin.Mechanism, folder: Path) -> Any:
    return str(symkin.singularity(machine, joints=_JOINTS))


def loci(machine: symkin.Mechanism, folder: Path) -> Any:
    solution = symkin.solve(machine, joints=_JOINTS).solution
    found = singular_loci(solution, ("crank1", "crank2"), starts=2)
    found.plot(folder / f"{machine.name}.loci.png")
    return [str(found), _digest(folder / f"{machine.name}.loci.png")]


def track(machine: symkin.Mechanism, folder: Path) -> Any:
    found = symkin.track(machine, joints=[_JOINTS, (25.0, -30.0)])
    found.plot(folder / f"{machine.name}.track.png")
    return [
        found.reached,
        found.certified,
        [s.radius for s in found.samples],
        _digest(folder / f"{machine.name}.track.png"),
    ]


def sweep(machine: symkin.Mechanism, folder: Path) -> Any:
    values = np.linspace(-20.0, 20.0, 2)
    swept = symkin.sweep(
        machine, {"crank1": values, "crank2": values}, folder / f"{machine.name}.zarr", workers=0
    )
    return sorted(swept.points_by_count.items())


def calibrate(machine: symkin.Mechanism, folder: Path) -> Any:
    rng = np.random.default_rng(0)
    joints = np.radians(rng.uniform(-20.0, 20.0, (12, 2)))
    places = [symkin.solve(machine, joints=np.degrees(q)).solution.position for q in joints]
    noisy = np.array(places) * [1, 1, 0] + rng.normal(0.0, 1e-3, (12, 3)) * [1, 1, 0]
    readings = Measurements(joints=joints, position=noisy, position_sigma=1e-3)
    fit = symkin.calibrate(
        machine, readings, parameters=["left.crank1.point.x", "left.crank1.zero"], method="lifted"
    )
    by_ipopt = symkin.calibrate(
        machine, readings, parameters=["left.crank1.point.x"], method="ipopt"
    )
    return [
        str(fit.status),
        fit.chi_square,
        by_ipopt.chi_square,
        hashlib.sha256(picture(residual_figure(fit))).hexdigest(),
    ]


def firmware(machine: symkin.Mechanism, folder: Path) -> Any:
    files = write_folder(machine, folder / f"{machine.name}.c", Options())
    return [_digest(path) for path in sorted(files)]


def plots(machine: symkin.Mechanism, folder: Path) -> Any:
    path = folder / f"{machine.name}.png"
    symkin.modes(machine, joints=_JOINTS).plot(path)
    return _digest(path)


def show(machine: symkin.Mechanism, folder: Path) -> Any:
    return describe(machine)


LONG: tuple[Verb, ...] = (loci, track, sweep, firmware, calibrate)
SHORT: tuple[Verb, ...] = (
    newton,
    modes_direct,
    ipopt,
    jacobian,
    modes_inverse,
    modes_sampled,
    singularity,
    show,
    load,
    plots,
)
ROUNDS = [(verb, verb) for verb in SHORT] + [
    (verb, other) for verb, other in zip(LONG, (newton, ipopt) * 3, strict=False)
]
"""What every fourth thread and what the others do at the same time."""


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def work(numbers: range, folder: Path, barrier: threading.Barrier, found: dict[str, Any]) -> None:
    """The rounds of the threads of these numbers."""
    for k, pair in enumerate(ROUNDS):
        barrier.wait()
        for number in numbers:
            verb = pair[number % 4 > 0]
            for machine in (0,) if verb in LONG else (0, 1)[: 1 + number % 2]:
                (inside := folder / f"{number}.{k}.{machine}").mkdir()
                found[f"{k}: {verb.__name__} of machine {machine}, thread {number}"] = verb(
                    make_machine(machine), inside
                )


def main(threads: int, folder: Path) -> None:
    barrier, found, failed = threading.Barrier(threads), {}, []

    def guarded(number: int) -> None:
        try:
            work(range(number, THREADS, threads), folder, barrier, found)
        except BaseException:
            barrier.abort()
            failed.append(number)
            raise

    started = [threading.Thread(target=guarded, args=(number,)) for number in range(threads)]
    for thread in started:
        thread.start()
    for thread in started:
        thread.join()
    (folder / "found.json").write_text(
        json.dumps(found, default=lambda a: np.asarray(a).tolist(), sort_keys=True)
    )
    sys.exit(bool(failed))


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]))
