"""The verb `convert`: write a mechanism as a file of another format."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Unpack

from symkin.errors import InputError, MechanismError
from symkin.files.outputs import check_output, write_output
from symkin.formats.gepetto_yaml import YAML_ENDINGS
from symkin.formats.graph_form import as_graph, is_closed_at_reference
from symkin.formats.load import load
from symkin.formats.read_options import AS_IT_IS, ReadOptions
from symkin.model.mechanism import Mechanism
from symkin.position.close import close
from symkin.position.options import ConvertOptions
from symkin.verb import read_as, verb

_CLOSED = 1e-12
"""Of the size: rods and couplings that miss their lengths and values by less are closed at the
reference.
"""


@verb(ConvertOptions)
def convert(
    mechanism: str | Path | Mechanism,
    path: Path | str,
    read: ReadOptions = AS_IT_IS,
    **options: Unpack[ConvertOptions],
) -> Path:
    """Write a mechanism as a mechanism file (.toml), MJCF (.xml), URDF (.urdf) or SDF (.sdf), by
    the path's suffix; returns the path.

    Takes what `load` takes, with what is told of a robot beside its file (`read`), or a Mechanism.
    The reference of the file is a closed configuration. The other formats hold links, joints, loops
    and couplings in metres and radians, masses are plain; `load` reads the same mechanism back, its
    limbs as joints and rods between links. `loops` of a URDF stand in it ("loop", those of URDF+)
    or in a file of the same name beside it ("yaml"). Raises InputError for another suffix, a folder
    that is missing and an output that would replace what is read, MechanismError for what the
    format cannot hold.

    >>> import symkin, tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     output = symkin.convert("ankle", pathlib.Path(folder) / "ankle.xml")
    ...     "<connect" in output.read_text()
    True
    """
    if not isinstance(mechanism, Mechanism):
        mechanism = read_as("str | Path", "mechanism", mechanism)
    loops = options["loops"]
    output, source = Path(path), "" if isinstance(mechanism, Mechanism) else mechanism
    check_output(output, tuple(_WRITERS), "convert", source)
    _check_loops(output, loops)
    found = _closed(mechanism if isinstance(mechanism, Mechanism) else load(mechanism, read))
    form = _WRITERS[output.suffix.lower()]
    if loops == "yaml":
        from symkin.formats.urdf_text import urdf_and_yaml

        text, beside = urdf_and_yaml(found)
        write_output(output.with_suffix(".yaml"), beside)
    elif form:
        writer = import_module(f"symkin.formats.{form}_text")
        text = getattr(writer, f"{form}_text")(found)
    else:
        text = found.to_toml()
    write_output(output, text)
    return output


def _check_loops(output: Path, loops: str) -> None:
    """Refuse a form of loops that the format has not, and loops beside a file that has its own."""
    if output.suffix.lower() != ".urdf":
        if loops != "loop":
            raise InputError(
                f"loops = {loops!r} is a form of URDF, and {str(output)!r} is none; leave it out"
            )
        return
    beside = [file for ending in YAML_ENDINGS if (file := output.with_suffix(ending)).is_file()]
    other = [file for file in beside if loops != "yaml" or file.suffix != ".yaml"]
    if other:
        raise InputError(
            f"{other[0]} stands beside the output, and would tell loops of a URDF of this name; "
            f"move it, or give another name"
            + ("" if loops == "yaml" else ", or --loops yaml, which replaces it")
        )


def _closed(mechanism: Mechanism) -> Mechanism:
    """The mechanism with a closed reference, its own where that is one. Raises MechanismError where
    nothing closes it.
    """
    if is_closed_at_reference(as_graph(mechanism), _CLOSED):
        return mechanism
    found = close(mechanism)
    if found.reference is None:
        raise MechanismError(
            f"{mechanism.name}: no closed configuration was found, and files hold one as their "
            f"reference; the best leaves "
            f"{found.residual:.3g} {mechanism.length_unit}"
        )
    return found.reference


_WRITERS = {".toml": "", ".xml": "mjcf", ".urdf": "urdf", ".sdf": "sdf"}
"""By suffix: the format that is written, but for mechanism files."""
