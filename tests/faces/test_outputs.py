"""Outputs of commands: regular files are replaced whole, links followed, devices and pipes written
into.
"""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import symkin
from helpers.inside import write_output

ARGUMENTS = {
    "jacobian": ["jacobian", "gluon_6l3", "--format", "numpy", "-o"],
    "track": [
        "track",
        "gluon_6l3",
        "--from",
        "0,0,0,0,0,0",
        "--to",
        "1,1,1,1,1,1",
        "--samples",
        "2",
        "-o",
    ],
    "simulate": [
        "calibrate",
        "simulate",
        "gluon_6l3",
        "--postures",
        "3",
        "--readings",
        "pose",
        "--force",
        "-o",
    ],
    "plot": ["modes", "gluon_6l3", "--plot"],
}
"""Commands that write one file, quick ones."""


def command(*arguments: object, **options):
    return subprocess.run(
        [sys.executable, "-m", "symkin", *map(str, arguments)],
        capture_output=True,
        check=False,
        timeout=120,
        **options,
    )


def read_pipe(path: Path) -> tuple[threading.Thread, list[bytes]]:
    """A thread that reads a named pipe to its end."""
    content: list[bytes] = []
    thread = threading.Thread(target=lambda: content.append(path.read_bytes()), daemon=True)
    thread.start()
    return thread, content


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", ARGUMENTS)
def test_links_stay_links_and_pipes_stay_pipes(name, tmp_path):
    """Through a link to a file of another folder, through a link to nothing yet, and into a pipe
    the same bytes go as into a file.
    """
    suffix = ".png" if name == "plot" else ".csv"
    (tmp_path / "away").mkdir()
    plain, old, new, pipe = (tmp_path / f"{n}{suffix}" for n in ("plain", "old", "new", "pipe"))
    kept, made = (tmp_path / "away" / f"{n}{suffix}" for n in ("kept", "made"))
    kept.write_text("before")
    kept.chmod(0o640)
    old.symlink_to(kept)
    new.symlink_to(Path("away") / made.name)
    os.mkfifo(pipe)
    thread, piped = read_pipe(pipe)
    for path in (plain, old, new, pipe):
        done = command(*ARGUMENTS[name], path)
        assert done.returncode == 0, done.stderr
    thread.join(30)
    assert old.is_symlink()
    assert new.is_symlink()
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert stat.S_IMODE(kept.stat().st_mode) == 0o640
    assert plain.read_bytes() == kept.read_bytes() == made.read_bytes() == piped[0]
    beside = {f"{p.name}.sha256" for p in (plain, old, new)} if name == "simulate" else set()
    assert {p.name for p in tmp_path.iterdir()} == {
        p.name for p in (plain, old, new, pipe, kept.parent)
    } | beside


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_devices_stay_devices():
    """A full device is an error in one line, the null device takes everything, and both are there
    afterwards.
    """
    with pytest.raises(symkin.InputError, match="/dev/full: the file cannot be written"):
        write_output("/dev/full", "text")
    write_output("/dev/null", "text")
    assert stat.S_ISCHR(Path("/dev/full").stat().st_mode)
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/stdout").exists(), reason="no /dev/stdout here")
@pytest.mark.parametrize("how", ["file", "append", "pipe"])
def test_the_standard_output_can_be_named(how, tmp_path):
    """-o /dev/stdout gives the text and then the name, in order, after what stood there."""
    arguments = [sys.executable, "-m", "symkin", *ARGUMENTS["jacobian"], "/dev/stdout"]
    text = command(*ARGUMENTS["jacobian"][:-1]).stdout
    if how == "pipe":
        assert (
            subprocess.run(arguments, capture_output=True, check=True).stdout
            == text + b"/dev/stdout\n"
        )
        return
    path = tmp_path / "out"
    path.write_bytes(b"before\n")
    with path.open("ab" if how == "append" else "wb") as file:
        subprocess.run(arguments, stdout=file, check=True)
    assert path.read_bytes() == (b"before\n" if how == "append" else b"") + text + b"/dev/stdout\n"


def test_a_reader_that_goes_away_is_one_line(tmp_path):
    """A pipe whose reader has gone, a folder, a missing folder, a loop of links: InputError that
    names the path.
    """
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    ready = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    closer = threading.Timer(0.2, os.close, [ready])
    closer.start()
    with pytest.raises(symkin.InputError, match="pipe: the file cannot be written"):
        write_output(pipe, "x" * 1_000_000)
    closer.join()
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    for path in (tmp_path, tmp_path / "missing" / "file", loop):
        with pytest.raises(symkin.InputError, match="cannot be written"):
            write_output(path, "text")
    assert {p.name for p in tmp_path.iterdir()} == {"pipe", "loop"}


def test_undecodable_names_are_written_as_escapes(tmp_path):
    """Text with a surrogate, as file names of other encodings give, becomes a file of UTF-8."""
    write_output(tmp_path / "t", "a\udcffb")
    assert (tmp_path / "t").read_text(encoding="utf-8") == "a\\udcffb"


@pytest.mark.slow
def test_firmware_goes_through_links(tmp_path):
    """A folder by a link, and in it a file that is a link: both stay links."""
    (tmp_path / "real").mkdir()
    (tmp_path / "folder").symlink_to(tmp_path / "real")
    (tmp_path / "real" / "manifest.json").symlink_to(tmp_path / "kept.json")
    arm = tmp_path / "arm.toml"
    joints = [
        symkin.Joint(f"q{k}", "R", (0.1 * k, 0, 0), (0, 0, 1), actuated=True) for k in range(2)
    ]
    arm.write_text(
        symkin.Mechanism(
            "arm", [symkin.Limb("arm", joints)], (0.2, 0, 0), serial=True, length_unit="m"
        ).to_toml()
    )
    done = command("firmware", arm, "-o", tmp_path / "folder")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "folder").is_symlink()
    assert (tmp_path / "real" / "manifest.json").is_symlink()
    assert b"model_sha256" in (tmp_path / "kept.json").read_bytes()


FULL = """
import os, resource, signal, sys
from pathlib import Path
from helpers.inside import write_output
from symkin import InputError
folder = Path(sys.argv[1])
os.chmod(folder, 0o555)
if os.getuid() == 0:
    os.setuid(65534)
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))  # a disk with room for no more
try:
    write_output(folder / "kept", "new" * 4096)
except InputError as error:
    print(error)
write_output(folder / "short", "new")
"""


def test_a_full_disk_loses_no_file_of_a_folder_that_takes_no_new_ones(tmp_path):
    """The folder cannot be written, the file can: it is written over, whole or not at all."""
    folder = tmp_path / "fixed"
    folder.mkdir()
    for name in ("kept", "short"):
        (folder / name).write_text("old" * 1000)
        (folder / name).chmod(0o666)
    for parent in (tmp_path, *tmp_path.parents[:3]):
        parent.chmod(parent.stat().st_mode | 0o055)
    done = subprocess.run(
        [sys.executable, "-c", FULL, folder],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])},
    )
    folder.chmod(0o755)
    assert (done.returncode, done.stderr) == (0, "")
    assert "kept: the file cannot be written (File too large)" in done.stdout
    assert (folder / "kept").read_text() == "old" * 1000
    assert (folder / "short").read_text() == "new"


def test_new_files_have_the_permissions_that_the_user_gives_new_files(tmp_path):
    before = os.umask(0o027)
    try:
        write_output(tmp_path / "new", "text")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o640


def test_settings_of_the_users_matplotlib_change_no_picture(tmp_path):
    """Sizes, resolutions and layouts of a matplotlibrc."""
    (tmp_path / "matplotlibrc").write_text(
        "figure.autolayout: True\nfigure.dpi: 3\nsavefig.dpi: 3\naxes.xmargin: 9\n"
    )
    pictures = []
    for folder in (tmp_path, tmp_path / "plain"):
        folder.mkdir(exist_ok=True)
        done = command("modes", "scara", "--plot", "modes.png", cwd=folder)
        assert done.returncode == 0, done.stderr
        pictures.append((folder / "modes.png").read_bytes())
    assert pictures[0] == pictures[1]


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are bytes")
def test_files_whose_names_are_no_text_are_read(tmp_path):
    """Names in another encoding: what is written of them is written with escapes."""
    source = Path(os.fsdecode(os.fsencode(tmp_path) + b"/f\xff.toml"))
    symkin.convert("four_bar", source)
    robot = source.with_suffix(".urdf")
    symkin.convert(source, robot)
    assert symkin.load(robot).source.endswith("f\\udcff.urdf")
    with pytest.raises(symkin.InputError, match="MuJoCo's compiler reads no file whose path"):
        symkin.load(symkin.convert(source, source.with_suffix(".xml")))
