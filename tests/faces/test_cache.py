"""The cache folder: only whole files of the user's own that say something true are used, and it
stays within its size.
"""

import io
import os
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.inside import (
    build_problem,
    cache_folder,
    keep,
    read_kept,
    start_files,
    start_store,
    system_of,
)
from helpers.samples import five_bar
from symkin import InputError


@pytest.fixture
def folder(monkeypatch, tmp_path):
    monkeypatch.setenv("SYMKIN_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("SYMKIN_ENGINE", "numpy")
    return tmp_path / "cache"


def _positions(title="five-bar"):
    """Of a five-bar's modes; another title makes it another mechanism, whose start a process reads
    anew.
    """
    mechanism = replace(five_bar(), motion="planar", title=title)
    return sorted(tuple(np.round(mode.position, 6)) for mode in symkin.modes(mechanism))


def _rewritten(content, change):
    """A start's file with some of its arrays changed."""
    data = dict(np.load(io.BytesIO(content)))
    file = io.BytesIO()
    np.savez(file, **change(data))
    return file.getvalue()


WRONG = {
    "other roots": lambda d: d | {"z": d["z"] + 0.1},
    "no numbers": lambda d: d | {"z": d["z"] * np.nan},
    "no roots": lambda d: d | {"z": d["z"][:, :0], "orbits": d["orbits"][:0]},
    "a root twice": lambda d: d | {"z": d["z"][:, [0] * d["z"].shape[1]]},
    "other known values": lambda d: d | {"k": d["k"] * 2},
    "too few known values": lambda d: d | {"k": d["k"][:1]},
    "orbits of other roots": lambda d: d | {"orbits": d["orbits"][:-1]},
    "another shape": lambda d: d | {"z": d["z"][:-1]},
    "text": lambda d: d | {"z": np.array("roots")},
    "mirrors of other roots": lambda d: d | {"maps": np.roll(d["maps"], 1)},
    "an array missing": lambda d: {key: d[key] for key in d if key != "k"},
}


@pytest.fixture(scope="module")
def shipped():
    """A system and the file of its start, whose roots have mirrors."""
    problem = build_problem(symkin.load("zhao2000"), "direct")
    system = system_of(problem)
    return system, (
        start_files.SHIPPED / f"{start_store.start_key(problem, system)}.npz"
    ).read_bytes()


@pytest.mark.parametrize("wrong", WRONG)
def test_a_start_is_checked_against_the_closure(shipped, wrong):
    """A file of the right form whose content is wrong is no start; the right one is, also when it
    is written anew.
    """
    system, content = shipped
    assert start_files._start_in(_rewritten(content, lambda d: d), system)[0] is not None
    assert start_files._start_in(_rewritten(content, WRONG[wrong]), system) is None


def test_why_there_is_no_start_is_believed_of_the_same_search(shipped):
    """What an older search did not find may be found now."""
    system, _ = shipped
    content = start_files.content_of(None, "paths are unresolved")
    assert start_files._start_in(content, system) == (None, "paths are unresolved")
    for older in (lambda d: d | {"searches": 1}, lambda d: {"reason": d["reason"]}):
        assert start_files._start_in(_rewritten(content, older), system) is None


@pytest.mark.slow
def test_a_wrong_start_of_the_right_name_is_made_anew(folder):
    """A file whose digest is right and whose content is not: the modes are those of an empty cache,
    the file goes.
    """
    right = _positions()
    (place,) = folder.glob("*.npz")
    key, content = place.name.split("-")[0], place.read_bytes()
    place.unlink()
    bad = keep(folder, key, ".npz", _rewritten(content, WRONG["other roots"]))
    assert _positions("another") == right
    assert not bad.exists()
    assert [p.read_bytes() for p in folder.glob("*.npz")] == [content]


def test_what_was_changed_or_cut_short_is_not_read(tmp_path):
    """The name tells the content; an empty file, a shorter one and one with another byte are no
    files.
    """
    place = keep(tmp_path, "key", ".npz", b"content")
    assert [content for _, content in read_kept(tmp_path, "key", ".npz")] == [b"content"]
    for content in (b"", b"conten", b"Content"):
        place.write_bytes(content)
        assert read_kept(tmp_path, "key", ".npz") == []
        assert not place.exists()


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
def test_a_fifo_or_a_device_does_not_block(folder):
    """In place of a file: it is taken for missing, and replaced, in a process that would otherwise
    never end.
    """
    place = keep(folder, "key", ".npz", b"content")
    place.unlink()
    os.mkfifo(place)
    (folder / "key-0123456789abcdef.npz").symlink_to("/dev/zero")
    code = (
        f"import sys, pathlib; from {inside.where('keep')} import *; f = "
        f"pathlib.Path(sys.argv[1]); print(read_kept(f, 'key', '.npz'))"
    )
    code += "; print(keep(f, 'key', '.npz', b'content').read_bytes())"
    done = subprocess.run(
        [sys.executable, "-c", code, folder], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.split() == ["[]", "b'content'"]


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no owners here")
def test_files_of_others_are_not_read_nor_removed(monkeypatch, tmp_path):
    place = keep(tmp_path, "key", ".so", b"library")
    monkeypatch.setattr(os, "getuid", lambda: 4711)
    assert read_kept(tmp_path, "key", ".so") == []
    assert place.exists()


def test_a_full_disk_leaves_nothing_behind(monkeypatch, tmp_path):
    """The unfinished file goes when its content, or its last name, cannot be written."""

    class Full(io.BytesIO):
        def write(self, _):
            raise OSError(28, "No space left on device")

    def full(handle, mode):
        os.close(handle)
        return Full()

    with monkeypatch.context() as patch:
        patch.setattr(cache_folder.os, "fdopen", full)
        assert keep(tmp_path, "key", ".npz", b"content") is None
    with monkeypatch.context() as patch:
        patch.setattr(
            cache_folder.os,
            "replace",
            lambda *_: (_ for _ in ()).throw(OSError(28, "No space left on device")),
        )
        assert keep(tmp_path, "key", ".npz", b"content") is None
    assert list(tmp_path.iterdir()) == []


def test_abandoned_files_go_at_the_next_writing(tmp_path):
    """Unfinished files of processes that were killed long ago; those of a process that may still
    write stay.
    """
    old, new = tmp_path / "tmpa.part", tmp_path / "tmpb.part"
    old.write_bytes(b"half")
    new.write_bytes(b"half")
    os.utime(old, (time.time() - 1e5,) * 2)
    keep(tmp_path, "key", ".npz", b"content")
    assert not old.exists()
    assert new.exists()


def test_the_folder_stays_within_its_size_and_keeps_what_was_used_last(monkeypatch, tmp_path):
    """Files of 100 kB in a folder of 1 MB: never more, the one that is read between stays, files of
    others too.
    """
    monkeypatch.setenv("SYMKIN_CACHE_SIZE", "1")
    (tmp_path / "notes.txt").write_bytes(bytes(2_000_000))
    for k in range(30):
        place = keep(tmp_path, f"key{k}", ".so", bytes([k]) * 100_000)
        os.utime(place, (time.time() - 1e6 + 1e4 * k,) * 2)
        assert len(read_kept(tmp_path, "key0", ".so")) == 1
        assert sum(p.stat().st_size for p in tmp_path.glob("*.so")) <= 1_000_000
    assert (tmp_path / "notes.txt").exists()
    assert len(read_kept(tmp_path, "key29", ".so")) == 1
    assert read_kept(tmp_path, "key1", ".so") == []


def test_a_cache_of_no_size_keeps_nothing(monkeypatch, folder):
    monkeypatch.setenv("SYMKIN_CACHE_SIZE", "0")
    assert keep(folder, "key", ".npz", b"content") is None
    assert not folder.exists()


@pytest.mark.parametrize("text", ["much", "-1", "nan"])
def test_a_size_that_is_none_is_refused(monkeypatch, text):
    monkeypatch.setenv("SYMKIN_CACHE_SIZE", text)
    with pytest.raises(InputError, match="SYMKIN_CACHE_SIZE"):
        cache_folder.cache_size()


WRITE = """
import sys
from pathlib import Path
from HERE import keep, read_kept
for k in range(200):
    keep(Path(sys.argv[1]), f"key{k % 7}", ".npz", bytes([k % 7]) * 100_000)
    for place, content in read_kept(Path(sys.argv[1]), f"key{(k + 3) % 7}", ".npz"):
        assert content == bytes([(k + 3) % 7]) * 100_000
""".replace("HERE", inside.where("keep"))


@pytest.mark.slow
def test_processes_share_a_folder(tmp_path):
    """Three write, read and remove in a folder that is too small for all: none reads what is wrong,
    none fails.
    """
    environment = os.environ | {"SYMKIN_CACHE_SIZE": "0.4"}
    runs = [
        subprocess.Popen([sys.executable, "-c", WRITE, str(tmp_path)], env=environment)
        for _ in range(3)
    ]
    assert [run.wait(120) for run in runs] == [0, 0, 0]
    assert list(tmp_path.glob("*.part")) == []
