"""Files that symkin has written are replaced only while they are as it wrote them: digests in a
manifest say what that was.

A folder of several files has `manifest.json`; a single file has its digest beside it, in
`FILE.sha256` as sha256sum writes it.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

from symkin.errors import InputError
from symkin.files.outputs import write_output

MANIFEST = "manifest.json"
_LINE = re.compile(r"([0-9a-f]{64})  (.+)")


def digest(content: bytes) -> str:
    """SHA-256 in hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()


def read_manifest(folder: Path, key: str) -> dict[str, Any]:
    """What a folder's manifest says; empty where there is none that can be read, or one without
    `key`, of another kind.
    """
    if not (folder / MANIFEST).is_file():  # reading a pipe would wait
        return {}
    try:
        content = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    is_ours = (
        isinstance(content, dict) and isinstance(content.get("files"), dict) and key in content
    )
    return content if is_ours else {}


def foreign_files(
    folder: Path, names: Iterable[str], digests: Mapping[str, Collection[str]]
) -> list[str]:
    """Those of the names that stand in the folder as folders, or as regular files of another
    content than `digests` allow.
    """
    return [
        name
        for name in names
        if (folder / name).exists() and not _is_own(folder / name, digests.get(name, ()))
    ]


def _is_own(path: Path, digests: Collection[str]) -> bool:
    """Whether nothing would be lost; devices and their like hold nothing."""
    return not path.is_dir() and (not path.is_file() or digest(path.read_bytes()) in digests)


def refuse_foreign(folder: Path, foreign: list[str], known: Collection[str], remedy: str) -> None:
    """Raise InputError for files in the way, of which `known` were once written by symkin."""
    edited = [name for name in foreign if name in known]
    if foreign:
        what = (
            "edited since they were written"
            if edited
            else "there already and not written by symkin"
        )
        raise InputError(
            f"{folder}: would replace {', '.join(edited or foreign)}, {what}; {remedy}"
        )


# --- single files ---------------------------------------------------------------------------------


def check_own_file(path: Path, *, force: bool = False) -> None:
    """Raise InputError where a file stands that symkin has not written, or that was edited since,
    unless `force`.
    """
    if force:
        return
    digests = {path.name: _recorded(path)}
    known = [path.name] if digests[path.name] else []
    remedy = "move it away, give another name with -o, or say --force"
    refuse_foreign(path.parent, foreign_files(path.parent, [path.name], digests), known, remedy)


def write_own_file(path: Path, text: str) -> None:
    """Write a text file and its digest. The digest comes first, beside that of the file that it
    replaces, so that a run which is cut short leaves no file that counts as foreign. A device or a
    pipe holds nothing, and gets no digest.
    """
    if path.exists() and not path.is_file():
        write_output(path, text)
        return
    before = foreign_files(path.parent, [path.name], {}) and [digest(path.read_bytes())]
    made = digest(text.encode())
    _record(path, [made, *before])
    write_output(path, text)
    _record(path, [made])


def _beside(path: Path) -> Path:
    return path.with_name(f"{path.name}.sha256")


def _recorded(path: Path) -> list[str]:
    """Digests that stand beside a file for it."""
    try:
        lines = _beside(path).read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return []
    return [
        match[1] for line in lines if (match := _LINE.fullmatch(line)) and match[2] == path.name
    ]


def _record(path: Path, digests: Iterable[str]) -> None:
    write_output(_beside(path), "".join(f"{d}  {path.name}\n" for d in digests))
