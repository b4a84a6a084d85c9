"""Mistakes in mechanism files, and the one line that names each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

import symkin
from symkin import MechanismError


def assert_refused_in_one_line(path: Path, text: str, fragments: Sequence[str]) -> None:
    """MechanismError of a file: its path first, then what it is about (`fragments`); one line, in
    our own words.
    """
    path.write_text(text, encoding="utf-8")
    with pytest.raises(MechanismError) as error:
        symkin.load(path)
    message = str(error.value)
    assert message.startswith(str(path))
    for fragment in fragments:
        assert fragment in message[len(str(path)) :]
    assert "\n" not in message
