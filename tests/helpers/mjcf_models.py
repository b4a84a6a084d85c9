"""Small robots in MJCF, one for each thing that the format can say of kinematics, and MuJoCo as an
independent account of them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from helpers.equality_rows import equality_rows
from helpers.inside import Closed, Robot

MODELS = Path(__file__).resolve().parent.parent / "data" / "models" / "mjcf"
REAL = ("cassie", "g1_parallel_ankle", "kangaroo_lower_body", "robotiq_2f85", "talos")


def file_text(world: str, rest: str = "", compiler: str = "") -> str:
    return (
        f'<mujoco model="made">\n<compiler angle="radian" {compiler}/>\n<worldbody>\n{world}\n'
        f"</worldbody>\n{rest}\n</mujoco>\n"
    )


def body(name: str, pos: str, inside: str, turn: str = "") -> str:
    return f'<body name="{name}" pos="{pos}" {turn}><geom size="0.1"/>{inside}</body>\n'


def joint(name: str, more: str = 'axis="0 0 1"') -> str:
    return f'<joint name="{name}" {more}/>'


_LEG = body(
    "thigh",
    "0 0 0",
    joint("hip") + body("shin", "0.3 0 0", joint("knee") + '<site name="toe" pos="0.4 0 0"/>'),
)
_CRANK = body(
    "crank", "0.5 0 0", joint("motor") + '<site name="pin" pos="0 0.2 0" euler="0 0 0.3"/>'
)

SMALL: dict[str, tuple[str, int, int]] = {
    # text, constraint rank at generic closed configurations, mobility
    "four_bar_by_sites": (
        file_text(_LEG + _CRANK, '<equality><connect site1="toe" site2="pin"/></equality>'),
        2,
        1,
    ),
    "four_bar_by_anchor": (
        file_text(
            _LEG + _CRANK,
            '<equality><connect body1="shin" body2="crank" anchor="0.4 0 0"/></equality>',
        ),
        2,
        1,
    ),
    "hinge_pair_ref_and_turned_frames": (
        file_text(
            body(
                "a",
                "0 0 1",
                joint("yaw", 'axis="0 0 2" ref="0.4"')
                + joint("pitch", 'axis="0 1 0" pos="0.1 0 0" range="-1 1"')
                + body(
                    "b",
                    "0 0.2 -0.4",
                    joint("slide", 'type="slide" axis="1 1 0" ref="0.05"')
                    + '<site name="s" pos="0.1 0.2 0.3"/>',
                    'euler="0.3 0.2 0.1"',
                ),
            )
            + body(
                "c",
                "0.4 0 0",
                joint("ball", 'type="ball" pos="0 0 0.1"') + '<site name="t" pos="0 0 1"/>',
                'quat="1 0.2 0.1 0.4"',
            ),
            '<equality><connect site1="s" site2="t"/></equality>',
        ),
        3,
        3,
    ),
    "weld": (
        file_text(
            body(
                "a",
                "0 0 0.5",
                "".join(
                    joint(f"a{k}", f'axis="{x}" pos="0.1 {k} 0"')
                    for k, x in enumerate(("1 0 0", "0 1 0", "0 0 1", "1 1 0"))
                ),
            )
            + body(
                "b",
                "0.6 0 0.5",
                "".join(
                    joint(f"b{k}", f'axis="{x}" pos="0.2 0 {k}"')
                    for k, x in enumerate(("1 0 1", "0 1 0", "1 0 0", "0 1 1"))
                ),
            ),
            '<equality><weld body1="a" body2="b" relpose="0.5 0.1 0 1 0.1 0.2 0" anchor="0.1 0.2 '
            '0.3"/></equality>',
        ),
        6,
        2,
    ),
    "platform_on_six_legs": (
        file_text(
            body(
                "top",
                "0 0 1",
                "<freejoint/>"
                + "".join(
                    f'<site name="t{k}" pos="{np.cos(k + 0.2 * (k % 2)):.3f} {np.sin(k + 0.1):.3f} '
                    f'0"/>'
                    for k in range(6)
                ),
            )
            + "".join(
                body(
                    f"leg{k}",
                    f"{1.5 * np.cos(k):.3f} {1.5 * np.sin(k):.3f} 0",
                    joint(f"u{k}", 'axis="1 0 0"')
                    + joint(f"v{k}", 'axis="0 1 0"')
                    + body(
                        f"rod{k}",
                        "0 0 0",
                        joint(f"length{k}", 'type="slide" axis="0 0 1"')
                        + f'<site name="e{k}" pos="0 0 0.9"/>',
                    ),
                )
                for k in range(6)
            ),
            "<equality>"
            + "".join(f'<connect site1="e{k}" site2="t{k}"/>' for k in range(6))
            + "</equality><actuator>"
            + "".join(f'<motor joint="length{k}"/>' for k in range(6))
            + "</actuator>",
        ),
        18,
        6,
    ),
    "couplings": (
        file_text(
            "".join(
                body(f"f{k}", f"{k} 0 0", joint(f"q{k}", f'axis="0 0 1" ref="{0.1 * k:.1f}"'))
                for k in range(6)
            ),
            '<tendon><fixed name="left"><joint joint="q2" coef="2"/><joint joint="q3" '
            'coef="-1"/></fixed>'
            '<fixed name="right"><joint joint="q0" coef="0.5"/></fixed></tendon><equality>'
            '<joint joint1="q0" joint2="q1" polycoef="0.1 0.5 0.2 -0.1 0.05"/><tendon '
            'tendon1="left" tendon2="right" polycoef="0 0.7 0 0 0"/>'
            '<joint joint1="q4" joint2="q2" polycoef="0.2 -1 0 0 0"/><joint joint1="q4" '
            'joint2="q3" polycoef="0 1 0 0 0"/>'
            '<joint joint1="q5" polycoef="0.3 0 0 0 0"/></equality><actuator><motor '
            'tendon="left"/><motor joint="q1"/></actuator>',
        ),
        4,
        1,
    ),
}
"""q5 is held and counts neither as a freedom nor as a constraint."""


class Account:
    """MuJoCo's own account of a file: poses of bodies, constraint violation and rank at
    configurations of a robot's tree.
    """

    def __init__(self, path: Path, robot: Robot) -> None:
        import mujoco

        self.mujoco, self.robot = mujoco, robot
        self.model = mujoco.MjModel.from_xml_path(str(path))
        self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT) | int(
            mujoco.mjtDisableBit.mjDSBL_LIMIT
        )
        self.start = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, self.start)

    def at(self, closed: Closed, state: np.ndarray) -> Any:
        """MuJoCo's data there; joints that the robot does not have stand as at qpos0."""
        mujoco, model = self.mujoco, self.model
        data = mujoco.MjData(model)
        values = closed.tree.by_name(state)
        poses = closed.tree.displacements(state)
        for j in range(model.njnt):
            name, place, number = (
                model.joint(j).name,
                int(model.jnt_qposadr[j]),
                int(model.jnt_bodyid[j]),
            )
            kind = int(model.jnt_type[j])
            if (
                kind == int(mujoco.mjtJoint.mjJNT_FREE)
                and model.body(number).name in self.robot.floating
            ):
                link = model.body(number).name
                pose = poses[link] @ self.robot.links[link]
                data.qpos[place : place + 7] = [*pose.position, *pose.quaternion]
            elif kind == int(mujoco.mjtJoint.mjJNT_BALL):
                data.qpos[place : place + 4] = self._ball(values[name], number)
            elif name in values:
                data.qpos[place] = values[name][0]
        mujoco.mj_forward(model, data)
        return data

    def _ball(self, value: np.ndarray, number: int) -> np.ndarray:
        """From the base frame's axes at the file's configuration to the body's own."""
        whole = self.start.xquat[number]
        back, half, result = np.zeros(4), np.zeros(4), np.zeros(4)
        self.mujoco.mju_negQuat(back, whole)
        self.mujoco.mju_mulQuat(half, back, value)
        self.mujoco.mju_mulQuat(result, half, whole)
        return result

    def equality_rows(self, data: Any) -> tuple[np.ndarray, np.ndarray]:
        """Violations and Jacobian of the equality constraints."""
        return equality_rows(self.mujoco, self.model, data)

    def free_roots(self) -> int:
        """Freedoms of the free joints that the robot holds."""
        free = self.mujoco.mjtJoint.mjJNT_FREE
        bodies = [
            int(self.model.jnt_bodyid[j])
            for j in range(self.model.njnt)
            if int(self.model.jnt_type[j]) == int(free)
        ]
        return sum(6 for b in bodies if self.model.body(b).name not in self.robot.floating)


def random_robot(seed: int) -> str:
    """A random tree of bodies with none to three joints of any type each, free ones among them, and
    a connect or weld of any form.
    """
    rng = np.random.default_rng(seed)

    def numbers(count: int = 3) -> str:
        return " ".join(f"{x:.4f}" for x in rng.normal(size=count))

    count = int(rng.integers(4, 8))
    parents = [int(rng.integers(0, k)) for k in range(1, count + 1)]

    def joints(number: int) -> str:
        if parents[number - 1] == 0 and rng.random() < 0.2:
            return "<freejoint/>"
        found = []
        for k in range(int(rng.choice([0, 1, 1, 2, 3]))):
            kind = str(rng.choice(["hinge", "hinge", "slide"]))
            found.append(
                f'<joint name="j{number}_{k}" type="{kind}" axis="{numbers()}" pos="{numbers()}" '
                f'ref="{rng.normal():.3f}"/>'
            )
        return (
            "".join(found)
            if rng.random() < 0.8
            else f'<joint name="ball{number}" type="ball" pos="{numbers()}"/>'
        )

    def text(number: int) -> str:
        inside = "".join(text(k + 1) for k, parent in enumerate(parents) if parent == number)
        site = f'<site name="s{number}" pos="{numbers()}" quat="{numbers(4)}"/>'
        return body(f"b{number}", numbers(), joints(number) + site + inside, f'quat="{numbers(4)}"')

    a, b = rng.choice(np.arange(1, count + 1), 2, replace=False)
    forms = [
        f'<connect site1="s{a}" site2="s{b}"/>',
        f'<connect body1="b{a}" body2="b{b}" anchor="{numbers()}"/>',
        f'<connect body1="b{a}" anchor="{numbers()}"/>',
        f'<weld body1="b{a}" body2="b{b}" anchor="{numbers()}"/>',
        f'<weld body1="b{a}" body2="b{b}" torquescale="0" anchor="{numbers()}"/>',
    ]
    world = "".join(text(k + 1) for k, parent in enumerate(parents) if parent == 0)
    return file_text(world, f"<equality>{rng.choice(forms)}</equality>")
