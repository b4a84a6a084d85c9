"""`symkin close`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from symkin.cli.options import JsonOption, MechArgument, output_option, print_result
from symkin.cli.pictures import Drawing, NamedPicture
from symkin.errors import InputError
from symkin.formats.read_options import ReadOptions

if TYPE_CHECKING:
    from symkin.position.close_result import ClosedConfiguration

_SUFFIXES = (".toml", ".json", ".xml")


def close(
    mech: MechArgument,
    read: ReadOptions,
    picture: NamedPicture,
    output: Annotated[
        Path | None,
        output_option(
            "Write the mechanism with the closed configuration as its reference (.toml), "
            "its JSON (.json), or an MJCF file with it as a keyframe (.xml).",
            "FILE",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> int:
    """Find the closed configuration nearest to the file's own: how far loops were open, rank,
    mobility. Exit status 3: none closes.
    """
    from symkin.files.outputs import write_output
    from symkin.position.close import close as close_one

    _check_output(output, mech)
    drawing = Drawing.checked(picture)
    found = close_one(mech, read)
    written = ""
    if output is not None and found.closed:
        write_output(output, _content(mech, found, output))
        written = f"\nwritten: {output}"
    written += drawing.of(found if found.closed else None)
    print_result(as_json, found, written)
    return 0 if found.closed else 3


def _check_output(output: Path | None, mech: str) -> None:
    """Refuse, before the work, an output that cannot be written or would replace what is read."""
    from symkin.files.outputs import check_output

    if output is None:
        return
    check_output(output, _SUFFIXES, "close", mech)
    if output.suffix.lower() == ".xml" and Path(mech).suffix.lower() != ".xml":
        raise InputError(
            f"output {str(output)!r}: a keyframe is written into a copy of an MJCF file, and "
            f"{mech} is none; give .toml or .json, or "
            "`symkin convert`"
        )


def _content(mech: str, found: ClosedConfiguration, output: Path) -> str | bytes:
    if output.suffix.lower() == ".json":
        return json.dumps(found.to_dict(), allow_nan=False, indent=1) + "\n"
    if output.suffix.lower() == ".xml":
        from symkin.formats.mjcf import with_keyframe

        return with_keyframe(Path(mech), found.joints, found.link_poses)
    if found.reference is None:
        raise InputError(f"output {str(output)!r}: {mech} has no joint that moves; give a .json")
    return found.reference.to_toml()
