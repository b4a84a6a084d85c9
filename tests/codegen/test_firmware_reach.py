"""OK of code whose passive joints are taken out of the rows means that these joints exist: limbs
that reach only a part of the sphere on which their rows hold the platform.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import symkin
from helpers import firmware_tools as tools
from helpers import moved_points
from helpers.gate import in_gate
from helpers.inside import LimbPlatform, Options, Real

UNTURNED = np.eye(3)
CENTRE = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
LIMBS = {
    "left": ((-120.0, 20.0, -60.0), (1.0, 0.2, 0.1), (0.4, 0.9, 0.3), (60.0, 50.0, 40.0)),
    "right": ((90.0, -110.0, -40.0), (0.1, 1.0, 0.3), (0.8, 0.5, -0.2), (-30.0, 70.0, 30.0)),
}
"""Of each limb the place of its U joint, the two oblique axes of it and its platform point."""
PERPENDICULAR = {
    name: (at, *np.linalg.svd([np.subtract(to, at)])[2][1:], to)
    for name, (at, _, _, to) in LIMBS.items()
}
"""The same limbs with axes that are perpendicular to each other and to the leg: they reach all of
the sphere.
"""


def joint(kind, name, point, axis=None, axis2=None, extra=""):
    text = f'type = "{kind}"\nname = "{name}"\npoint = {list(map(float, point))}\n'
    text += "" if axis is None else f"axis = {list(map(float, axis))}\n"
    return text + ("" if axis2 is None else f"axis2 = {list(map(float, axis2))}\n") + extra


def joints_of(name, limb, turn, scale, *, revolutes):
    """The joints of a limb U P S, its U as two R if so."""
    at, first, second, to = (np.array(turn) @ np.array(v) for v in limb)
    at, to = scale * at, scale * to
    u = (
        [joint("R", f"{name}_a", at, first), joint("R", f"{name}_b", at, second)]
        if revolutes
        else [joint("U", f"{name}_u", at, first, second)]
    )
    p = joint("P", f"{name}_p", at, to - at, extra="actuated = true\n")
    return [*u, p, joint("S", f"{name}_s", to)]


def as_limbs(path, limbs=LIMBS, turn=UNTURNED, scale=1.0, revolutes=False, order=1):
    """A platform that slides on an axis and turns about it, held by limbs."""
    head = 'format = 1\nname = "reach"\nlength_unit = "mm"\nangle_unit = "deg"\n[platform]\n'
    head += f"position = {(scale * np.array(turn) @ [20.0, 10.0, 30.0]).tolist()}\n"
    parts = [(n, joints_of(n, limb, turn, scale, revolutes=revolutes)) for n, limb in limbs.items()]
    point, axis = (np.array(turn) @ np.array(v) for v in CENTRE)
    parts.append(("centre", [joint("C", "centre_c", point, axis)]))
    for name, made in parts[::order]:
        head += f'[[limb]]\nname = "{name}"\n' + "".join(f"[[limb.joint]]\n{j}" for j in made)
    path.write_text(head)
    return symkin.load(path)


def as_graph(path):
    """The same as a graph of links and joints."""
    text = 'format = 1\nname = "reach"\nlength_unit = "mm"\nangle_unit = "deg"\n'
    for name, limb in LIMBS.items():
        chain = ["base", f"{name}_cross", f"{name}_foot", f"{name}_rod", "plate"]
        for k, made in enumerate(joints_of(name, limb, UNTURNED, 1.0, revolutes=True)):
            text += f"[[joint]]\nlinks = {chain[k : k + 2]}\n{made}".replace("'", '"')
    text += f'[[joint]]\nlinks = ["base", "plate"]\n{joint("C", "centre", *CENTRE)}'
    path.write_text(text)
    return symkin.load(path)


def turned():
    q, _ = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


WRITTEN = {
    "U": {},
    "R R": {"revolutes": True},
    "turned": {"turn": turned()},
    "tiny": {"scale": 1e-4},
    "huge": {"scale": 1e4},
    "other order": {"order": -1},
}


def asked(made, poses, **options):
    tools.compiler("gcc")
    closes = tools.bench_module("closes")
    code = closes.Asked(made, Options(**options))
    return closes.closes(code, poses, np.random.default_rng(3))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("written", "real", "poses"),
    in_gate([("U", "float", 8), *product(WRITTEN, ("float", "double"), [24])], [("U", "float", 8)]),
)
def test_ok_means_that_passive_joints_exist(written, real, poses, tmp_path):
    """Joint values and poses on and off what the limbs reach: an OK closes, what is reached is
    taken.
    """
    made = as_limbs(tmp_path / "m.toml", **WRITTEN[written])
    assert LimbPlatform(made, Options(real), Real(real)).core is not None
    tally = asked(made, poses, real=real)
    assert tally.wrong == 0, tally.said
    assert tally.moved == 0, tally.said
    assert tally.taken == tally.feasible > 0
    assert tally.feasible < tally.ok < tally.goals


@pytest.mark.slow
@pytest.mark.parametrize("poses", in_gate([8, 24], [8]))
def test_ok_of_a_map_means_that_passive_joints_exist(poses, tmp_path):
    """The same machine as a graph."""
    made = as_graph(tmp_path / "m.toml")
    sides = {"given": ("left_p", "right_p"), "find": ("centre.angle", "centre.slide")}
    tally = asked(made, poses, **sides)
    assert tally.wrong == 0, tally.said
    assert tally.moved == 0, tally.said
    assert 0 < tally.ok < tally.goals


@pytest.mark.parametrize("written", in_gate(list(WRITTEN), ["U"]))
def test_nothing_is_asked_where_passive_joints_always_exist(written, tmp_path):
    """Axes that are perpendicular; a share of a degree aside something is asked."""
    options = WRITTEN[written]
    for aside in (0.0, 1e-3):
        limbs = {
            name: (at, first, np.add(second, np.multiply(aside, first)), to)
            for name, (at, first, second, to) in PERPENDICULAR.items()
        }
        made = as_limbs(tmp_path / "m.toml", limbs, **options)
        kind = LimbPlatform(made, Options("double"), Real("double"))
        assert kind.core is not None
        assert len(kind.passive_checks) == (len(limbs) if aside else 0)


def test_passive_joints_stay_where_formulas_do_not_say_whether_they_exist():
    """U joints that a crank turns and that are oblique stay unknowns."""
    made = moved_points.six_rss(rods=False)
    limbs = [
        replace(
            limb,
            joints=[
                replace(j, axis2=tuple(np.add(j.axis2, np.multiply(0.3, j.axis))))
                if j.type == "U"
                else j
                for j in limb.joints
            ],
        )
        for limb in made.limbs
    ]
    oblique = replace(made, limbs=limbs)
    assert LimbPlatform(oblique, Options("double"), Real("double")).core is None
