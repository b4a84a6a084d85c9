"""Options of `symkin calibrate` that nothing would read, refused."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from symkin.ignored_options import refuse_ignored
from symkin.model.mechanism import Mechanism


def refuse_unread_noise(readings: Sequence[str], inclination: str | None, position: str | None, orientation: str | None) -> None:
    """Refuse the noise of readings that are not taken."""
    for name, noise in {"inclination": inclination, "position": position, "orientation": orientation}.items():
        if name not in readings and (name == "inclination" or "pose" not in readings):
            refuse_ignored({f"--noise-{name}": noise}, f"no {name} is read", "name it with --readings")


def refuse_unread_drawing(
    mechanism: Mechanism, plan: Path | None, postures: int | None, groups: int | None, *,
    box: str | None, tilt: str | None, spin: str | None,
) -> None:  # fmt: skip
    """Refuse what random postures are drawn by where a plan gives the postures, and a workspace of poses where an arm is drawn
    by its joints."""
    workspace = {"--box": box, "--tilt": tilt, "--spin": spin}
    if plan is not None:
        drawn = {"--postures": postures, "--groups": groups, **workspace}
        refuse_ignored(drawn, "the plan gives the postures and their groups", "leave --plan out")
    elif mechanism.serial:
        unread = {name: value for name, value in workspace.items() if name != "--tilt" or not groups}
        refuse_ignored(unread, "postures of a serial arm are drawn by its joints, within their limits")
