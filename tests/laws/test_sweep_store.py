"""The folder of a sweep: labelled arrays that hold what `symkin.modes` finds, resumed bit for bit,
never overwritten.
"""

import errno
import math
import os
import shutil
import sys
import threading
import warnings
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symkin
from helpers.folders import same_files
from helpers.inside import COMPLETENESS, classify, make_plan, make_space, store
from helpers.needed import Later, needs
from helpers.sweep_points import tables_of
from symkin import InputError, Pose, sweep

xarray = Later("xarray")
pytestmark = needs("xarray")
PLATFORM = symkin.load("zhang2009")
GRID = {"leg1": np.linspace(100, 160, 8), "leg2": np.linspace(320, 370, 5)}
ONE = {"leg1": [140.0]}


class Stops(ThreadPoolExecutor):
    """Raises after some chunks, as a driver that is interrupted between two of them."""

    def __init__(self, after):
        super().__init__(1)
        self.left = after

    def submit(self, fn, /, *args, **kwargs):
        self.left -= 1
        if self.left < 0:
            raise KeyboardInterrupt
        return super().submit(fn, *args, **kwargs)


class Backwards(ThreadPoolExecutor):
    """Runs what it is given in pairs, the later one first."""

    def __init__(self):
        super().__init__(2)
        self.kept = None

    def submit(self, fn, /, *args):
        future = Future()
        if self.kept is None:
            self.kept = (future, fn, args)
        else:
            future.set_result(fn(*args))
            self.kept[0].set_result(self.kept[1](*self.kept[2]))
            self.kept = None
        return future


def test_arrays_hold_the_modes(tmp_path):
    """At each grid point the arrays have the count, poses and joints of `symkin.modes`, and NaN
    beyond.
    """
    swept = sweep(PLATFORM, GRID, tmp_path / "s", workers=0, chunk=7)
    data = swept.open().load()
    assert data["count"].dims == ("leg1", "leg2")
    assert data.leg1.attrs["units"] == "mm"
    assert data.position.attrs["units"] == "mm"
    assert data.sizes["mode"] == data["count"].max() == swept.most_modes
    assert swept.points == sum(swept.points_by_count.values()) == 40
    for i, j in [(0, 0), (3, 2), (7, 4)]:
        point = data.isel(leg1=i, leg2=j)
        alone = symkin.modes(
            PLATFORM, joints=[GRID["leg1"][i], GRID["leg2"][j], *PLATFORM.example.joints[2:]]
        )
        assert int(point["count"]) == len(alone)
        for k, mode in enumerate(alone):
            assert np.allclose(point.position[k], mode.position, atol=1e-8)
            assert np.allclose(point.quaternion[k], mode.quaternion, atol=1e-10)
            for name, value in mode.joints.items():
                assert float(point.joints.sel(joint=name)[k]) == pytest.approx(value, abs=1e-8)
        assert np.isnan(point.position[len(alone) :]).all()
    assert data.completeness.attrs["flag_meanings"] == list(COMPLETENESS)
    assert data.attrs["mechanism_file"] == PLATFORM.to_toml()


def test_opening_gives_no_warning(tmp_path):
    """`xarray.open_zarr` reads a folder at once, finished or not."""
    with pytest.raises(KeyboardInterrupt):
        sweep(PLATFORM, GRID, tmp_path / "s", executor=Stops(3), chunk=7)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = xarray.open_zarr(tmp_path / "s").load()
    assert 0 < int(data.done.sum()) < 6
    assert int((data["count"] >= 0).sum()) < 40


@pytest.mark.slow
@pytest.mark.parametrize(
    ("after", "engine"), [(1, ""), pytest.param(4, "numpy", marks=pytest.mark.long)]
)
def test_interrupted_sweeps_go_on_bit_for_bit(tmp_path, monkeypatch, after, engine):
    """A sweep that stopped goes on with the chunks that are left, and its files equal an
    uninterrupted one's, with either engine.
    """
    monkeypatch.setenv("SYMKIN_ENGINE", engine)
    sweep(PLATFORM, GRID, tmp_path / "whole", workers=0, chunk=7)
    with pytest.raises(KeyboardInterrupt):
        sweep(PLATFORM, GRID, tmp_path / "cut", executor=Stops(after), chunk=7)
    before = int(xarray.open_zarr(tmp_path / "cut").done.sum())
    swept = sweep(PLATFORM, GRID, tmp_path / "cut", workers=0, chunk=7)
    assert swept.computed == swept.chunks - before
    assert same_files(tmp_path / "whole", tmp_path / "cut")
    assert sweep(PLATFORM, GRID, tmp_path / "cut", workers=0, chunk=7).computed == 0


def test_half_written_chunks_are_computed_again(tmp_path):
    """Data without its mark, leftovers of a write and arrays of unequal length are what a kill can
    leave: all is mended.
    """
    import zarr

    sweep(PLATFORM, GRID, tmp_path / "whole", workers=0, chunk=7)
    shutil.copytree(tmp_path / "whole", tmp_path / "torn")
    torn = zarr.open_group(tmp_path / "torn", mode="r+", use_consolidated=False)
    torn["done"][2:4] = 0
    torn["position"][2] = -7.0
    torn["joints"].resize((8, 5, 1, 6))
    leftover = next((tmp_path / "torn" / "position" / "c").rglob("*"))
    (leftover.parent / "0.abc.partial").write_bytes(b"half")
    assert sweep(PLATFORM, GRID, tmp_path / "torn", workers=0, chunk=7).computed == 2
    assert same_files(tmp_path / "whole" / "position", tmp_path / "torn" / "position")
    assert (tmp_path / "whole" / "zarr.json").read_bytes() == (
        tmp_path / "torn" / "zarr.json"
    ).read_bytes()


def test_order_of_completion_leaves_no_trace(tmp_path):
    """Chunks that are done in another order, and the growth of the array of modes with them, give
    the same files.
    """
    grid = {"leg1": np.linspace(110, 150, 6), "leg2": [347.0, 350.0]}
    sweep(PLATFORM, grid, tmp_path / "a", workers=0, chunk=1)
    sweep(PLATFORM, grid, tmp_path / "b", executor=Backwards(), chunk=1)
    assert same_files(tmp_path / "a", tmp_path / "b")
    counts = xarray.open_zarr(tmp_path / "a")["count"].values
    assert len(np.unique(counts)) > 1


def test_one_point_and_axes_of_one_value(tmp_path):
    """A sweep of one point is a sweep; an axis of one value keeps its dimension."""
    data = sweep(PLATFORM, ONE, tmp_path / "one", workers=0).open()
    assert data["count"].shape == (1,)
    data = sweep(
        PLATFORM, {"leg1": [140.0], "leg2": [340.0, 347.0]}, tmp_path / "two", workers=0
    ).open()
    assert data["count"].dims == ("leg1", "leg2")
    assert data["count"].shape == (1, 2)


def test_samples_are_labelled_by_point(tmp_path):
    """A random sample has the dimension `point`, and the swept values as its coordinates."""
    data = (
        sweep(
            PLATFORM,
            {"leg1": (140, 150), "leg2": (340, 350)},
            tmp_path / "s",
            random=9,
            seed=1,
            workers=0,
        )
        .open()
        .load()
    )
    assert data["count"].dims == ("point",)
    assert {"leg1", "leg2"} <= set(data.coords)
    assert np.allclose(data.joints.sel(joint="leg1").values[:, 0], data.leg1.values)


def test_points_without_solution_and_off_the_motion(tmp_path):
    """Out of reach, or off a restricted motion, the count is 0, and completeness tells them
    apart.
    """
    beyond = sweep(PLATFORM, {"leg1": [140.0, 1000.0]}, tmp_path / "a", workers=0).open().load()
    assert beyond["count"].values.tolist() == [4, 0]
    assert set(np.array(COMPLETENESS)[beyond.completeness.values]) == {"probability one"}
    restricted = symkin.load("zhao2000")
    turned = (
        sweep(restricted, {"rz": [0.0, 90.0]}, tmp_path / "b", poses=True, workers=0).open().load()
    )
    assert turned["count"].values.tolist() == [8, 8]
    assert set(np.array(COMPLETENESS)[turned.completeness.values]) == {"probability one"}
    assert turned.rz.attrs["units"] == "deg"
    tilted = Pose(np.array([0.0, 0.0, 100.0]), np.array([math.cos(0.2), math.sin(0.2), 0.0, 0.0]))
    finder = make_plan(make_space(restricted, {"z": [100.0]}, over="poses")).finder()
    found = tables_of(finder, [{"pose": tilted}])
    assert found.count.tolist() == [0]
    assert [COMPLETENESS[code] for code in found.completeness] == ["off the motion"]


def test_conditioning_and_reach(tmp_path):
    """Each mode's distances from singularities are those of its own configuration, the best and
    worst condition those of the listed modes; an input is reached where some mode lies within
    limits.
    """
    grid = {"leg1": [120.0, 140.0, 1000.0]}
    whole = sweep(PLATFORM, grid, tmp_path / "m", workers=0).open().load()
    best = sweep(PLATFORM, grid, tmp_path / "c", quantity="conditioning", workers=0).open().load()
    assert np.array_equal(
        whole.condition.min("mode").values, best.least_condition.values, equal_nan=True
    )
    assert np.array_equal(
        whole.condition.max("mode").values, best.largest_condition.values, equal_nan=True
    )
    assert "position" not in best
    for k in range(4):
        alone = symkin.modes(PLATFORM, joints=[140.0, *PLATFORM.example.joints[1:]])[k]
        for kind, expected in classify(alone).distances.items():
            assert float(best[f"distance_{kind.replace(' ', '_')}"][1, k]) == pytest.approx(
                expected, abs=1e-9
            )
    assert np.isnan(best.distance_type_2.values[2]).all()
    reach = sweep(PLATFORM, grid, tmp_path / "r", quantity="reach", workers=0).open().load()
    assert np.array_equal(reach.reached.values == 1, whole["count"].values > 0)
    assert np.array_equal(reach.count_within_limits.values, whole["count"].values)


# --- refusals -------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"chunk": 8}, "chunk is 7 there and 8 here"),
        ({"seed": 1}, "seed is 0 there and 1 here"),
        ({"quantity": "reach"}, "quantity"),
        ({"certify": True}, "certify"),
        ({"at": [1, 2, 3, 4, 5, 6]}, "base"),
        ({"random": 4}, "axes"),
        ({"starts": 5}, "starts is 2000"),
    ],
)
def test_other_options_are_refused(tmp_path, options, said):
    """Another sweep in the folder is refused by what differs, and the folder left as it was."""
    grid = {"leg1": [140.0, 150.0], "leg2": [340.0, 347.0]}
    sweep(PLATFORM, grid, tmp_path / "s", workers=0, chunk=7)
    shutil.copytree(tmp_path / "s", tmp_path / "kept")
    with pytest.raises(InputError, match=said):
        sweep(PLATFORM, grid, tmp_path / "s", workers=0, **({"chunk": 7} | options))
    assert same_files(tmp_path / "s", tmp_path / "kept")


def test_changed_mechanisms_and_axes_are_refused(tmp_path, monkeypatch):
    """A mechanism whose file has changed, other axes and another engine are named."""
    grid = {"leg1": [140.0, 150.0]}
    sweep(PLATFORM, grid, tmp_path / "s", workers=0)
    changed = replace(PLATFORM, platform_position=(0.0, 0.0, 1.0))
    with pytest.raises(InputError, match="the file of zhang2009 has changed"):
        sweep(changed, grid, tmp_path / "s", workers=0)
    with pytest.raises(
        InputError, match=r"axes are leg1 \(2 values from 140.0 to 150.0\).*to 151.0"
    ):
        sweep(PLATFORM, {"leg1": [140.0, 151.0]}, tmp_path / "s", workers=0)
    with pytest.raises(InputError, match="mechanism is zhang2009 there and other here"):
        sweep(replace(PLATFORM, name="other"), ONE, tmp_path / "s", workers=0)
    monkeypatch.setenv("SYMKIN_ENGINE", "numpy")
    if "compiled" in xarray.open_zarr(tmp_path / "s").attrs["engine"]:
        with pytest.raises(InputError, match="engine is compiled C there and NumPy"):
            sweep(PLATFORM, grid, tmp_path / "s", workers=0)


def test_folders_that_hold_something_else_are_left_alone(tmp_path):
    """A folder with other files, a file, and a Zarr group of others are refused and unchanged; an
    empty folder is taken.
    """
    import zarr

    other, file, group, empty = (tmp_path / name for name in ("other", "file", "group", "empty"))
    other.mkdir()
    (other / "thesis.txt").write_text("keep")
    file.write_text("keep")
    zarr.create_group(group, attributes={"mine": 1})
    empty.mkdir()
    for folder, said in ((other, "is no sweep"), (file, "is a file"), (group, "is no sweep")):
        with pytest.raises(InputError, match=said):
            sweep(PLATFORM, ONE, folder, workers=0)
    assert [p.name for p in other.iterdir()] == ["thesis.txt"]
    assert sweep(PLATFORM, ONE, empty, workers=0).points == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["empty", "file", "group", "other"]


def test_a_full_disk_is_a_sentence_and_the_sweep_goes_on(tmp_path, monkeypatch):
    """No space is said, what is done is kept, and the same call finishes bit for bit."""
    sweep(PLATFORM, GRID, tmp_path / "whole", workers=0, chunk=7)
    opened, left = Path.open, [80]

    def full(self, mode="r", *arguments, **options):
        left[0] -= "w" in mode
        if left[0] == 0:
            with opened(self, mode) as file:
                file.write(b"half")
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return opened(self, mode, *arguments, **options)

    monkeypatch.setattr(Path, "open", full)
    with pytest.raises(InputError, match=r"No space left.*what is done is kept"):
        sweep(PLATFORM, GRID, tmp_path / "s", workers=0, chunk=7)
    monkeypatch.setattr(Path, "open", opened)
    sweep(PLATFORM, GRID, tmp_path / "s", workers=0, chunk=7)
    assert same_files(tmp_path / "whole", tmp_path / "s")


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere"
)
def test_folders_without_permission(tmp_path):
    """A folder that may not be written is a sentence."""
    (tmp_path / "closed").mkdir(mode=0o500)
    with pytest.raises(InputError, match="cannot be written"):
        sweep(PLATFORM, ONE, tmp_path / "closed" / "s", workers=0)


def test_parents_that_are_files(tmp_path):
    """A path through a file cannot be made."""
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match="cannot be written"):
        sweep(PLATFORM, ONE, tmp_path / "file" / "s", workers=0)


def test_two_runs_do_not_share_a_folder(tmp_path):
    """A second run in the same folder is refused while the first goes on."""

    def again(done, total):
        if done:
            with pytest.raises(InputError, match="another run"):
                sweep(PLATFORM, {"leg1": [140.0, 150.0]}, tmp_path / "s", workers=0)
            raised.append(total)

    raised = []
    sweep(PLATFORM, {"leg1": [140.0, 150.0]}, tmp_path / "s", workers=0, progress=again)
    assert raised


@pytest.mark.slow
@pytest.mark.parametrize("there", [False, True])
def test_runs_that_begin_a_folder_together(tmp_path, there):
    """Each ends with all points, or says that another run writes; the folder is whole, and nothing
    is left beside it.
    """
    folder, said, begin = tmp_path / "s", [], threading.Barrier(4)
    if there:
        folder.mkdir()

    def run():
        begin.wait()
        try:
            said.append(sweep(PLATFORM, {"leg1": [140.0, 150.0]}, folder, workers=0).points)
        except InputError as error:
            said.append(str(error))

    threads = [threading.Thread(target=run) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert 2 in said
    assert all(
        answer == 2 or "another run is writing into this folder" in answer for answer in said
    ), said
    assert [path.name for path in tmp_path.iterdir()] == ["s"]
    assert not list(folder.glob(".*"))
    assert sweep(PLATFORM, {"leg1": [140.0, 150.0]}, folder, workers=0).points == 2


def test_a_folder_that_comes_while_its_sweep_is_made(tmp_path, monkeypatch):
    """The run that is second goes on with the first one's folder, or finds it in use; a folder of
    something else is left alone.
    """
    made = store.create_arrays

    def first(folder, *arguments):
        made(folder, *arguments)
        made(tmp_path / "s", *arguments)

    def other(folder, *arguments):
        made(folder, *arguments)
        (tmp_path / "t").mkdir()
        (tmp_path / "t" / "notes").write_text("mine")

    monkeypatch.setattr(store, "create_arrays", first)
    assert sweep(PLATFORM, ONE, tmp_path / "s", workers=0).points == 1
    monkeypatch.setattr(store, "create_arrays", other)
    with pytest.raises(InputError, match="holds something that is no sweep, and is left alone"):
        sweep(PLATFORM, ONE, tmp_path / "t", workers=0)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["s", "t"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"quantity": "speed"}, "modes, conditioning, reach"),
        ({"chunk": 0}, "chunk = 0"),
        ({"starts": 0}, "starts = 0"),
        ({"workers": -1}, "workers = -1"),
        ({"workers": 1, "dask": "tcp://x"}, "together"),
    ],
)
def test_options_that_are_refused(tmp_path, options, said):
    """Each mistake is a sentence, and nothing is created."""
    with pytest.raises(InputError, match=said):
        sweep(
            PLATFORM,
            ONE,
            tmp_path / "s",
            **({"workers": 0} if "workers" not in options else {}),
            **options,
        )
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize("missing", ["zarr", "xarray"])
def test_missing_extra_is_named(tmp_path, monkeypatch, missing):
    """Without zarr or xarray the sentence says what to install."""
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(InputError, match=r"pip install 'symkin\[sweep\]'"):
        sweep(PLATFORM, ONE, tmp_path / "s", workers=0)


def test_writing_needs_no_xarray(tmp_path, monkeypatch):
    """A sweep that writes does not load what reads: a second of a small one's two."""
    monkeypatch.delitem(sys.modules, "xarray", raising=False)
    sweep(PLATFORM, ONE, tmp_path / "s", workers=0)
    assert "xarray" not in sys.modules
