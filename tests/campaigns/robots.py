"""A campaign over robots of others: every MJCF, URDF and SDF file of a folder is read, closed and
checked, one line each.

    python tests/campaigns/robots.py FOLDER [--modes] [--json FILE] [--timeout S]

Each file has a process of its own. Its line tells what was read, rank and mobility (generic: at
closed configurations beside the closed one), how far the loops were open and are, and what other
tools say; or the sentence with which it is refused. With --modes the actuated joints stand at the
reference, other joints too where that leaves a motion free, and the line ends with the modes of
each block.

The other tools: MuJoCo for MJCF (poses of all bodies at the file's configuration and at a random
one of the tree, violation and rank of its equality constraints at the closed configuration),
Pinocchio for URDF (poses of all links of the tree, at 0 and at random), for SDF an account by
maximal coordinates (sdf_twin.py: poses, and the mobility at the file's configuration). Exit status
1 where a file ends in a traceback, or was read otherwise than the other tool reads it.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from helpers.inside import is_robot
from oracle.robot_twins import DisagreementError, mujoco_agreement, pinocchio_agreement
from oracle.sdf_twin import sdf_agreement
from symkin import SymkinError

_STATES = ("read", "open", "refused", "timed out", "crashed", "read otherwise")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument(
        "--modes",
        action="store_true",
        help="list the modes at the reference's actuated values, too",
    )
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="write all that is found into a file"
    )
    parser.add_argument(
        "--timeout", type=float, default=60.0, metavar="S", help="seconds that one file may take"
    )
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        for part in _account(options.folder, modes=options.modes):
            print(json.dumps(part), flush=True)
        return
    files = list(robot_files(options.folder))
    if not files:
        sys.exit(f"{options.folder}: no MJCF, URDF or SDF file is found")
    found = []
    for path in files:
        entry = _in_a_process(path, modes=options.modes, timeout=options.timeout)
        entry["file"] = (
            str(path.relative_to(options.folder)) if options.folder.is_dir() else str(path)
        )
        found.append(entry)
        print(line_of(entry), flush=True)
    print(summary_of(found))
    if options.json is not None:
        options.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    sys.exit(any(entry["status"] in ("crashed", "read otherwise") for entry in found))


def robot_files(folder: Path) -> Iterator[Path]:
    """Files of robots in a folder and those below, by their suffix; of .xml those whose root
    element is <mujoco>.
    """
    for path in sorted(folder.rglob("*")) if folder.is_dir() else [folder]:
        if path.is_file() and is_robot(path) and (path.suffix.lower() != ".xml" or _is_model(path)):
            yield path


def _is_model(path: Path) -> bool:
    """Whether an XML file is a model of MuJoCo, and no part that others include."""
    text = path.read_bytes()
    return (
        re.search(rb"<mujoco[\s>]", text) is not None
        and re.search(rb"<worldbody|<include", text) is not None
    )


# --- one file -------------------------------------------------------------------------------------


def _in_a_process(path: Path, *, modes: bool, timeout: float) -> dict[str, Any]:
    command = [sys.executable, __file__, str(path), "--one", *(["--modes"] if modes else [])]
    begin, late = time.perf_counter(), False
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout)
        output, errors, failed = done.stdout, done.stderr, done.returncode != 0
    except subprocess.TimeoutExpired as stopped:
        output, errors, failed, late = (stopped.stdout or b"").decode(), "", False, True
    entry: dict[str, Any] = {"seconds": time.perf_counter() - begin}
    for line in output.splitlines():
        entry |= json.loads(line) if line.startswith("{") else {}
    if failed:
        entry |= {"status": "crashed", "sentence": " / ".join(errors.strip().splitlines()[-1:])}
    elif late:
        entry |= (
            {"modes": f"not within {timeout:g} s"}
            if entry.get("checked")
            else {"status": "timed out"}
        )
    return entry


def _account(path: Path, *, modes: bool) -> Iterator[dict[str, Any]]:
    """What is found of a file, in parts, so that a slow one does not lose the others."""
    from helpers.inside import close_robot, read_robot

    begin = time.perf_counter()
    try:
        robot = read_robot(path)
        found = close_robot(robot)
    except SymkinError as error:
        yield {"status": "refused", "sentence": str(error), "seconds": time.perf_counter() - begin}
        return
    account = found.to_dict()
    kept = (
        "links",
        "joint_count",
        "loops",
        "rows",
        "rank",
        "mobility",
        "generic",
        "open_by",
        "residual",
        "notes",
    )
    yield {
        "status": "read" if found.closed else "open",
        "seconds": time.perf_counter() - begin,
        **{key: account[key] for key in kept},
        "couplings": len(robot.couplings),
        "actuated": len(found.actuated),
    }
    agreement = {".xml": mujoco_agreement, ".urdf": pinocchio_agreement, ".sdf": sdf_agreement}.get(
        path.suffix.lower()
    )
    try:
        yield {"checked": "no other tool" if agreement is None else agreement(path, robot)}
    except DisagreementError as error:
        yield {"status": "read otherwise", "checked": "read otherwise", "sentence": str(error)}
    if modes and found.reference is not None:
        yield {"modes": _modes(found.reference)}


def _modes(mechanism: Any) -> str:
    """The modes of each block, where the actuated joints and as many others as leave nothing free
    stand at the reference.
    """
    import symkin
    from helpers.inside import determination, problem_of, read_given

    values = {
        c.name: _reference(mechanism, c.name)
        for c in mechanism.coordinates
        if c.kind != "quaternion"
    }
    given: dict[str, float] = {}
    driven = [c.name for c in mechanism.actuated if c.name in values]
    try:
        for name in driven or values:
            trial = given | {name: values[name]}
            said = determination(problem_of(mechanism, read_given(mechanism, None, None, trial)))
            if not said.decided:
                given = trial | {other: values[other] for other in said.binding if not driven}
            if not driven and given:
                break
        left = (
            determination(problem_of(mechanism, read_given(mechanism, None, None, given))).binding
            if given
            else ()
        )
        given |= {name: values[name] for name in left}
        found = symkin.modes(mechanism, given=given)
    except SymkinError as error:
        return f"none listed: {error}"
    blocks = " x ".join(str(group.count) for group in found.groups)
    return (
        f"{found.total}{f' = {blocks}' if blocks else ''} ({found.completeness}; {len(given)} "
        f"given)"
    )


def _reference(mechanism: Any, name: str) -> float:
    joint = next((entry.joint for entry in mechanism.link_joints if entry.joint.name == name), None)
    return 0.0 if joint is None else float(joint.zero)


# --- texts ----------------------------------------------------------------------------------------


def line_of(entry: dict[str, Any]) -> str:
    """What is said of a file in one line."""
    head = f"{entry['file']}: {entry['status']}"
    if "links" not in entry:
        return f"{head}: {entry.get('sentence', '')} [{entry['seconds']:.1f} s]"
    generic = entry["generic"]["mobility"]
    parts = [
        f"{entry['links']} links, {entry['joint_count']} joints, {entry['loops']} loops, "
        f"{entry['couplings']} couplings, "
        f"{entry['actuated']} actuated, {len(entry['notes'])} notes",
        f"rank {entry['rank']} of {entry['rows']}, mobility {entry['mobility']} (generic "
        f"{'not clear' if generic is None else generic})",
        f"open by {entry['open_by']:.1e}, closed to {entry['residual']:.1e} m",
        entry.get("sentence") or entry.get("checked", ""),
        *([f"modes {entry['modes']}"] if "modes" in entry else []),
    ]
    return f"{head}: {'; '.join(part for part in parts if part)} [{entry['seconds']:.1f} s]"


def summary_of(found: list[dict[str, Any]]) -> str:
    """How many files ended how."""
    counts = {state: sum(entry["status"] == state for entry in found) for state in _STATES}
    checked = sum(str(entry.get("checked", "")).startswith("as ") for entry in found)
    loops = sum(bool(entry.get("rows")) for entry in found)
    worst = max((entry["seconds"] for entry in found), default=0.0)
    told = ", ".join(f"{count} {state}" for state, count in counts.items())
    return (
        f"{len(found)} files: {told}; {loops} with loops or couplings; {checked} as another tool "
        f"reads them; slowest {worst:.1f} s"
    )


if __name__ == "__main__":
    np.seterr(all="ignore")
    main()
