"""A cache folder in which others may write: none of their code runs, whenever they exchange what is
there, and work goes on without it.

Each hostile library leaves a mark as it is loaded. The tests hold for root, who can give files to
other users, and for anybody else.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import casadi as ca
import pytest

import symkin
from helpers.inside import (
    AlgebraicSystem,
    CompilerError,
    Coordinate,
    NotBuiltError,
    c_library,
    compiled,
    find_compilers,
    folder_fault,
    keep,
    load_library,
    read_kept,
)
from helpers.samples import five_bar
from symkin import InputError, view

pytestmark = pytest.mark.skipif(
    not hasattr(os, "getuid") or shutil.which("cc") is None,
    reason="owners and a C compiler are needed",
)
GOOD = {"number.c": "int number(void) { return 1; }"}
ANOTHER_USER = 65534
OPEN = [0o777, 0o1777, 0o775, 0o757]


def load(
    folder: Path, *, build: bool = True, symbols: tuple[str, ...] = ("number",)
) -> ctypes.CDLL:
    return load_library(find_compilers("", os.environ["PATH"]), GOOD, symbols, folder, build=build)


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A library that answers 666 and makes a mark when it is loaded; and the mark's path."""
    folder = tmp_path_factory.mktemp("hostile")
    mark, source = folder / "mark", folder / "evil.c"
    source.write_text(
        f"#include <stdio.h>\nint number(void) {{ return 666; }}\n"
        f'__attribute__((constructor)) void run(void) {{ fclose(fopen("{mark}", "w")); }}'
    )
    subprocess.run(
        ["cc", "-shared", "-fPIC", str(source), "-o", str(folder / "evil.so")], check=True
    )
    return folder / "evil.so", mark


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    """A cache of the user's own that holds the good library."""
    folder = tmp_path / "cache"
    assert load(folder).number() == 1
    return folder


@pytest.mark.parametrize("mode", OPEN)
def test_a_folder_in_which_others_may_write_is_not_used(kept: Path, mode: int) -> None:
    """The sticky bit of a folder for all changes nothing: others may put files there. A folder
    within it, of the user's own, is good.
    """
    kept.chmod(mode)
    with pytest.raises(
        CompilerError,
        match=r"others may write in .*cache, and exchange what is in it; SYMKIN_CACHE may name",
    ):
        load(kept)
    (key,) = {place.name.split("-")[0] for place in kept.glob("*.so")}
    assert read_kept(kept, key, ".so") == []
    before = sorted(kept.iterdir())
    assert keep(kept, "key", ".npz", b"content") is None
    assert sorted(kept.iterdir()) == before
    assert load(kept / "own").number() == 1
    assert (kept / "own").stat().st_mode & 0o777 == 0o700


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="root gives files away")
def test_a_folder_of_another_user_is_not_used(kept: Path) -> None:
    os.chown(kept, ANOTHER_USER, ANOTHER_USER)
    assert "belongs to another user" in (folder_fault(kept) or "")
    with pytest.raises(CompilerError, match="belongs to another user"):
        load(kept)


def test_modes_are_found_without_compiled_code_and_say_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sentence stands where the engine is named."""
    monkeypatch.delenv("SYMKIN_ENGINE", raising=False)
    tmp_path.chmod(0o777)
    monkeypatch.setenv("SYMKIN_CACHE", str(tmp_path))
    z, k = ca.SX.sym("z"), ca.SX.sym("k")
    system = AlgebraicSystem(
        1.0, (Coordinate("x", "length", "passive"),), z, k, ca.vertcat(z**2 - k), ()
    )
    found, reason = compiled.load(system)
    assert found is None
    assert f"others may write in {tmp_path}" in reason
    modes = symkin.modes(symkin.load("zhang2009"))
    assert len(modes) > 0
    assert f"NumPy (others may write in {tmp_path}" in str(modes.engine)
    assert list(tmp_path.iterdir()) == []


def test_a_page_is_not_written_where_others_may_exchange_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tmp_path.chmod(0o777)
    monkeypatch.setenv("SYMKIN_CACHE", str(tmp_path))
    with pytest.raises(InputError, match=r"others may write in .*; or write the page with --html"):
        view(five_bar()).open()


@pytest.mark.parametrize("what", ["other file", "link", "link to another user's", "writable"])
def test_what_stands_in_a_librarys_place_is_not_run(
    kept: Path, hostile: tuple[Path, Path], what: str
) -> None:
    evil, mark = hostile
    (place,) = kept.glob("*.so")
    if what == "writable":
        place.chmod(0o666)
    else:
        place.unlink()
        if what == "other file":
            shutil.copy(evil, place)
        else:
            place.symlink_to(evil if what == "link" else "/usr/bin/env")
    with pytest.raises(NotBuiltError):
        load(kept, build=False)
    assert load(kept).number() == 1
    assert not mark.exists()


def test_a_file_that_is_exchanged_after_the_check_is_not_run(
    kept: Path, hostile: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is loaded is what was checked, also in place of the newly compiled one."""
    evil, mark = hostile

    def then_exchanged(*args: object) -> object:
        found = read_kept(*args)  # type: ignore[arg-type]
        for place, _ in found:
            shutil.copy(evil, place)
        return found

    with monkeypatch.context() as patch:
        patch.setattr(c_library, "read_kept", then_exchanged)
        assert load(kept, build=False).number() == 1
    for place in kept.glob("*.so"):
        place.unlink()

    def kept_and_exchanged(*args: object) -> Path | None:
        place = keep(*args)  # type: ignore[arg-type]
        assert place is not None
        shutil.copy(evil, place)
        return place

    monkeypatch.setattr(c_library, "keep", kept_and_exchanged)
    assert load(kept).number() == 1
    assert not mark.exists()


@contextmanager
def attacker(place: Path, files: list[Path]) -> Iterator[None]:
    """A thread that puts other files, and links to them, in a file's place for as long as the block
    lasts.
    """
    over, aside = threading.Event(), place.with_name("aside")

    def work() -> None:
        while not over.is_set():
            for file in files:
                with suppress(OSError):
                    shutil.copy2(file, aside)
                    if os.getuid() == 0 and file is files[0]:
                        os.chown(aside, ANOTHER_USER, ANOTHER_USER)
                    os.replace(aside, place)
                with suppress(OSError):
                    aside.symlink_to(file)
                    os.replace(aside, place)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@pytest.mark.slow
@pytest.mark.parametrize("mode", [0o700, 0o777])
def test_an_attacker_who_exchanges_files_all_the_time(
    kept: Path, hostile: tuple[Path, Path], mode: int, tmp_path: Path
) -> None:
    """Three hundred loads: the good library, or none."""
    evil, mark = hostile
    (place,) = kept.glob("*.so")
    copy = Path(shutil.copy(place, tmp_path / "good.so"))
    kept.chmod(mode)
    loaded = 0
    with attacker(place, [evil, copy]):
        for _ in range(300):
            with suppress(CompilerError):
                assert load(kept, build=False).number() == 1
                loaded += 1
    assert not mark.exists()
    assert loaded == 0 or mode == 0o700


def test_a_library_without_a_function_is_made_anew(kept: Path) -> None:
    """The user's own file under the name of another library; and one that is compiled without the
    function.
    """
    (place,) = kept.glob("*.so")
    source = kept / "other.c"
    source.write_text("int other(void) { return 2; }")
    subprocess.run(["cc", "-shared", "-fPIC", str(source), "-o", str(kept / "other")], check=True)
    place.unlink()
    wrong = keep(kept, place.name.split("-")[0], ".so", (kept / "other").read_bytes())
    assert load(kept).number() == 1
    assert wrong is not None
    assert not wrong.exists()
    with pytest.raises(CompilerError, match="it has no function nothing"):
        load(kept, symbols=("nothing",))


def test_where_files_in_memory_are_not_there_a_private_file_is_loaded(
    kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And removed; in a temporary folder in which everybody may exchange it, none is made."""
    monkeypatch.delattr(os, "memfd_create", raising=False)
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(c_library.tempfile, "tempdir", str(temporary))
    assert load(kept, build=False).number() == 1
    assert list(temporary.iterdir()) == []
    temporary.chmod(0o777)
    with pytest.raises(CompilerError, match="everybody may exchange files in the temporary folder"):
        load(kept)


def test_many_libraries_are_told_apart(kept: Path, tmp_path: Path) -> None:
    """The loader knows libraries by their paths: each copy has its own, and none keeps a file
    open.
    """
    before = len(os.listdir("/proc/self/fd")) if Path("/proc/self/fd").is_dir() else None
    for number in range(5):
        sources = {"number.c": f"int number(void) {{ return {number}; }}"}
        compilers = find_compilers("", os.environ["PATH"])
        assert (
            load_library(compilers, sources, ("number",), tmp_path / "many", build=True).number()
            == number
        )
    assert load(kept).number() == 1
    if before is not None:
        assert len(os.listdir("/proc/self/fd")) == before
