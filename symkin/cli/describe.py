"""`symkin show`, `symkin close` and `symkin convert`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from symkin.cli.options import JsonOption, MechArgument, output_option, print_either, print_result
from symkin.cli.pictures import Drawing, NamedPicture
from symkin.cli.values import Asked
from symkin.errors import InputError
from symkin.formats.read_options import ReadOptions
from symkin.position.options import ConvertOptions
from symkin.verb_options import OUTPUT, Option

if TYPE_CHECKING:
    from symkin.position.close_result import ClosedConfiguration


def show(
    mech: MechArgument,
    read: ReadOptions,
    picture: NamedPicture,
    latex: Annotated[
        bool,
        Option("Print the closure equations as LaTeX.", group=OUTPUT),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Show limbs, unknowns, rank, mobility, redundant constraints and reciprocal screws."""

    if latex and as_json:
        raise InputError(
            "both --latex and --json are given; the equations are LaTeX, the account is JSON: give "
            "one of them"
        )
    asked = Asked.of(mech, read, picture=picture)
    mechanism, drawing = asked.mechanism, asked.drawing
    if drawing.path is not None:
        from symkin.plots.figures import draw_sketch

        draw_sketch(mechanism, drawing.path, **drawing.options)
    if latex:
        from symkin.codegen.text.latex import equations

        print(equations(mechanism))
        return
    from symkin.position.describe import describe
    from symkin.position.mobility import mobility

    drawn = "" if drawing.path is None else f"\n\npicture: {drawing.path}"
    print_either(
        as_json, lambda: mobility(mechanism).to_dict(), lambda: describe(mechanism) + drawn
    )


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


def convert(
    mech: MechArgument,
    read: ReadOptions,
    output: Annotated[
        Path,
        output_option("The file to write: .toml, .xml (MJCF), .urdf or .sdf.", "FILE"),
    ],
    options: ConvertOptions,
) -> None:
    """Write a mechanism in another format: `symkin convert ankle -o ankle.xml`. Its kinematics are
    the same; masses are plain.
    """
    from symkin.position.convert import convert as convert_one

    written = convert_one(mech, output, read, **options)
    print(f"written: {written}")
    if options["loops"] == "yaml":
        print(f"written: {written.with_suffix('.yaml')}")
