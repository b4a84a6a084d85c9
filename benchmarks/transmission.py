"""4,096 closed ankles of the G1 at once under JAX: the array file with Jacobians and second
derivatives, beside MJX making one step of the same ankles with their `connect` constraints.

    python benchmarks/transmission.py [--count 4096] [--repeats 9]

MJX takes Newton's method with one iteration, the least that it allows: what it does without
approaching the constraints is not faster.
"""

from __future__ import annotations

import argparse
import statistics
import types
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

import symkin
from timing import Figure, in_turn, median_ratio

MODEL = Path(__file__).resolve().parents[1] / "tests/data/models/mjcf/g1_parallel_ankle.xml"
OWN, PEER = "array file, first and second derivatives", "MJX, one step"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--count", type=int, default=4096)
    parser.add_argument("--repeats", type=int, default=9)
    told = parser.parse_args()
    for name, times in measured(told.count, told.repeats).items():
        print(f"{name:45} {1e3 * statistics.median(times):8.1f} ms   min {1e3 * min(times):.1f}")


def figures(*, quick: bool, seed: int) -> Iterator[Figure]:  # noqa: ARG001 - goals are one set
    """The array file over MJX."""
    name = "transmission: 4,096 ankles, over one step of MJX"
    try:
        times = measured(4096, 3 if quick else 9)
    except ModuleNotFoundError as error:
        yield Figure(name, None, f"{error.name} is not installed")
        return
    own = 1e3 * statistics.median(times[OWN])
    yield Figure(name, median_ratio(times[OWN], times[PEER]), f"{own:.1f} ms")


def measured(count: int, repeats: int) -> dict[str, list[float]]:
    """Processor seconds of each, in turn, after compilation."""
    import jax

    jax.config.update("jax_enable_x64", True)
    goals = jax.numpy.asarray(np.random.default_rng(0).uniform(-0.25, 0.25, (count, 2)))
    own = jax.jit(jax.vmap(_file()))
    runs: dict[str, Callable[[], object]] = {OWN: lambda: jax.block_until_ready(own(goals))}
    step, state = _mjx(count)
    runs[PEER] = lambda: jax.block_until_ready(step(state).qpos)
    return in_turn(runs, repeats)


def _file() -> Callable[[Any], Any]:
    """What a training loop asks of the file, the way that it iterates."""
    import jax.numpy as jnp

    from symkin.codegen.map.transmission_array import array_source

    robot = symkin.load(MODEL)
    ankle = symkin.transmission(robot, ranges={"roll_joint": (-0.26, 0.26)}).found[0]
    made = types.ModuleType("ankle")
    exec(compile(array_source(ankle), "ankle", "exec"), made.__dict__)

    def of_motors(motors: Any) -> Any:
        joints = made.joints(motors, xp=jnp)
        return (
            joints,
            made.jacobian(motors, joints, xp=jnp),
            made.second(motors, joints, xp=jnp),
        )

    return of_motors


def _mjx(count: int) -> tuple[Callable[[Any], Any], Any]:
    """A step of many ankles, and where it begins: somewhat apart from each other."""
    import jax
    import mujoco

    mjx = import_module("mujoco.mjx")
    model = mujoco.MjModel.from_xml_path(str(MODEL))
    model.opt.solver, model.opt.iterations = mujoco.mjtSolver.mjSOL_NEWTON, 1
    model.opt.ls_iterations = 1
    told, begin = mjx.put_model(model), mjx.make_data(model)
    apart = jax.numpy.asarray(np.random.default_rng(1).uniform(-1e-3, 1e-3, (count, model.nq)))
    states = jax.vmap(lambda qpos: begin.replace(qpos=qpos))(apart)
    return jax.jit(jax.vmap(lambda state: mjx.step(told, state))), states


if __name__ == "__main__":
    main()
