"""Files of a sweep's folder that were lost or damaged are noticed when it is opened, and what they
held is computed again.
"""

from __future__ import annotations

import json
import shutil
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.gate import each_once
from helpers.inside import Swept, main
from helpers.needed import needs
from symkin import InputError, sweep

pytestmark = needs("xarray")
PLATFORM = symkin.load("zhang2009")
GRID = {"leg1": np.linspace(100, 160, 4), "leg2": np.linspace(320, 370, 3)}
CHUNK = 3
OLD = Path(__file__).parents[1] / "data" / "sweeps" / "layout_2.zip"
"""A folder that was written before files had checksums of their own."""


def swept(folder: Path) -> Swept:
    return sweep(PLATFORM, GRID, folder, workers=0, chunk=CHUNK)


def content(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("damage") / "whole"
    swept(folder)
    return folder


def lose(path: Path) -> None:
    path.unlink()


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-3])


def empty(path: Path) -> None:
    path.write_bytes(b"")


def blank(path: Path) -> None:
    """Of the same length, all zero: what a power cut leaves."""
    path.write_bytes(bytes(path.stat().st_size))


ARRAYS = [
    "count",
    "completeness",
    "position",
    "quaternion",
    "joints",
    "residual",
    "done",
    "leg1",
    "joint",
    "axis",
]


@pytest.mark.slow
@pytest.mark.parametrize(("array", "harm"), each_once(ARRAYS, [lose, cut, empty, blank]))
def test_a_harmed_file_is_written_anew(array, harm, whole, tmp_path) -> None:
    """Whatever file is harmed and however, the folder holds the same bytes afterwards, and no count
    is a fill value.
    """
    folder = tmp_path / "s"
    shutil.copytree(whole, folder)
    files = sorted(path for path in (folder / array / "c").rglob("*") if path.is_file())
    harm(files[len(files) // 2])
    found = swept(folder)
    assert content(folder) == content(whole)
    assert -1 not in found.points_by_count
    assert found.computed <= 1
    if array not in ("done", "leg1", "joint", "axis"):
        assert found.damaged == 1
        assert "1 chunk was lost or damaged and is computed again" in str(found)


def test_a_folder_of_an_earlier_layout_is_read_and_left_alone(tmp_path) -> None:
    """Its arrays, table and map are those of the same sweep now; it is not gone on with."""
    folder, same = tmp_path / "old", tmp_path / "new"
    with zipfile.ZipFile(OLD) as packed:
        packed.extractall(folder)
    grid = {"leg1": np.linspace(100, 160, 4), "leg2": [320.0, 370.0]}
    before = content(folder)
    with pytest.raises(InputError, match=r"another version of symkin.*can be read"):
        sweep(PLATFORM, grid, folder, workers=0, chunk=3)
    found = sweep(PLATFORM, grid, same, workers=0, chunk=3)
    old = replace(found, folder=folder)
    there, here = old.open().load(), found.open().load()
    for name in ("count", "completeness", "position", "joints", "leg1"):
        np.testing.assert_allclose(there[name].values, here[name].values, atol=1e-9)
    assert old.write_csv(tmp_path / "old.csv") == found.write_csv(tmp_path / "new.csv")
    assert old.plot() is not None
    assert content(folder) == before


def test_a_lost_description_is_said(whole, tmp_path) -> None:
    """What a number means cannot be made up."""
    folder = tmp_path / "s"
    shutil.copytree(whole, folder)
    (folder / "count" / "zarr.json").unlink()
    with pytest.raises(InputError, match=r"count/zarr\.json.*lost or damaged"):
        swept(folder)


@pytest.mark.parametrize(
    ("array", "key", "value"),
    [
        ("count", "data_type", "float64"),
        ("count", "data_type", "int64"),
        ("count", "fill_value", 7),
        ("position", "shape", [4, 3, 1, 2]),
        ("done", "data_type", "int8"),
        ("leg1", "data_type", "float32"),
        ("leg1", "shape", [7]),
        ("joint", "data_type", "float64"),
        ("residual", "dimension_names", ["leg2", "leg1", "mode"]),
        ("residual", "codecs", [{"name": "bytes", "configuration": {"endian": "little"}}]),
        ("count", "chunk_grid", {"name": "regular", "configuration": {"chunk_shape": [1, 1]}}),
    ],
)
def test_a_description_that_says_something_else_is_said(
    whole, tmp_path, array: str, key: str, value: object
) -> None:
    """Numbers are not read as what they are not."""
    folder = tmp_path / "s"
    shutil.copytree(whole, folder)
    file = folder / array / "zarr.json"
    told = json.loads(file.read_text())
    assert told[key] != value
    file.write_text(json.dumps(told | {key: value}))
    with pytest.raises(InputError, match=rf"{array}/zarr\.json.*lost or damaged"):
        swept(folder)


def test_the_command_says_what_was_lost(whole, tmp_path, capsys) -> None:
    """The same options go on in the harmed folder; the histogram has no -1."""
    folder = tmp_path / "s"
    shutil.copytree(whole, folder)
    shutil.rmtree(folder / "count" / "c")
    options = [
        "--grid",
        "leg1=100:160:4,leg2=320:370:3",
        "-o",
        str(folder),
        "--workers",
        "0",
        "--chunk",
        str(CHUNK),
    ]
    with pytest.raises(SystemExit) as stop:
        main(["sweep", "zhang2009", *options])
    printed = capsys.readouterr().out
    assert not stop.value.code
    assert "-1:" not in printed
    assert "4 chunks were lost or damaged and are computed again" in printed
