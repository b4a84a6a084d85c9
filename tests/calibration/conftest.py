"""Fits write their folders without rasterising the pictures, which takes longer than a fit."""

import pytest

from helpers import inside

PICTURE = b"\x89PNG\r\n\x1a\n"
"""The signature of a PNG file, in place of the whole."""


@pytest.fixture
def rasterised():
    """Pictures of this test are written as outside the tests."""


@pytest.fixture(autouse=True)
def _no_pixels(request, monkeypatch):
    """Figures are made; of their files only the signature is written."""
    if "rasterised" not in request.fixturenames:
        monkeypatch.setattr(inside.picture_file, "picture", lambda *_: PICTURE)
