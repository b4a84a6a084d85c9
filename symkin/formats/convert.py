"""The verb `convert`: write a mechanism as a file of another format."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from symkin.files.outputs import check_output, write_output
from symkin.formats.load import load
from symkin.formats.read_options import AS_IT_IS, ReadOptions
from symkin.formats.written_tree import require_closed_reference
from symkin.model.mechanism import Mechanism


def convert(mechanism: str | Path | Mechanism, path: str | Path, read: ReadOptions = AS_IT_IS) -> Path:
    """Write a mechanism as a mechanism file (.toml), MJCF (.xml), URDF (.urdf) or SDF (.sdf), by the path's suffix; returns the path.

    Takes what `load` takes, with what is told of a robot beside its file (`read`), or a Mechanism. The reference of the file is a closed configuration. The other formats hold links, joints,
    loops and couplings in metres and radians, masses are plain; `load` reads the same mechanism back, its limbs as joints and rods
    between links. Raises InputError for another suffix, a folder that is missing and an output that would replace what is read,
    MechanismError for what the format cannot hold.

    >>> import symkin, tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     output = symkin.convert("ankle", pathlib.Path(folder) / "ankle.xml")
    ...     "<connect" in output.read_text()
    True
    """
    output = Path(path)
    check_output(output, tuple(_WRITERS), "convert", "" if isinstance(mechanism, Mechanism) else mechanism)
    found = mechanism if isinstance(mechanism, Mechanism) else load(mechanism, read)
    write_output(output, _WRITERS[output.suffix](found))
    return output


def _toml(mechanism: Mechanism) -> str:
    require_closed_reference(mechanism, "the file")
    return mechanism.to_toml()


def _mjcf(mechanism: Mechanism) -> str:
    from symkin.formats.mjcf_text import mjcf_text

    return mjcf_text(mechanism)


_WRITERS: dict[str, Callable[[Mechanism], str]] = {".toml": _toml, ".xml": _mjcf}
