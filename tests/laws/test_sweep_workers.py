"""Workers of every kind give the same bits, and a kill of one, or of the driver, loses the chunks
under way only.
"""

import json
import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import time

import numpy as np
import pytest

import symkin
from helpers import inside
from helpers.folders import same_files
from helpers.inside import Crew, Here, local_crew
from helpers.needed import needs
from symkin import InputError, sweep

pytestmark = needs("zarr")
PLATFORM = symkin.load("zhang2009")
TEXT = "leg1=100:160:30,leg2=330:370:10"
GRID = {"leg1": np.linspace(100, 160, 30), "leg2": np.linspace(330, 370, 10)}
CHUNK = 10


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of an uninterrupted sweep in one process."""
    folder = tmp_path_factory.mktemp("sweep") / "whole"
    sweep(PLATFORM, GRID, folder, workers=0, chunk=CHUNK)
    return folder


def started(folder, *more):
    """The command, running."""
    command = [
        sys.executable,
        "-m",
        "symkin",
        "sweep",
        "zhang2009",
        "--grid",
        TEXT,
        "--chunk",
        str(CHUNK),
        "-o",
        str(folder),
        *more,
    ]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def marks(folder):
    return sum(path.suffix != ".partial" for path in (folder / "done" / "c").glob("*"))


def wait_for(condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.01)


def children(pid):
    found = []
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                with open(f"/proc/{entry}/stat") as file:
                    if int(file.read().rsplit(")", 1)[1].split()[1]) == pid:
                        found.append(int(entry))
            except OSError:
                pass
    return found


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.skipif(not os.path.isdir("/proc"), reason="needs /proc")
@pytest.mark.usefixtures("heard_interrupts")
@pytest.mark.parametrize("sign", [signal.SIGKILL, signal.SIGINT])
def test_a_killed_or_interrupted_driver_loses_nothing(whole, tmp_path, sign):
    """After kill -9 or Ctrl-C of the command its workers end, what is marked is kept, and the same
    command goes on to the same files. Ctrl-C ends with one line that says so and status 130, or by
    the signal, which a shell calls 130 too: Python may end so after the interrupt has passed
    through source text that it was executing.
    """
    process = started(tmp_path / "cut", "--workers", "2")
    wait_for(lambda: marks(tmp_path / "cut") >= 2 or process.poll() is not None)
    workers = children(process.pid)
    process.send_signal(sign)
    _, said = process.communicate(timeout=60)
    assert process.returncode in (
        (130, -signal.SIGINT) if sign == signal.SIGINT else (-signal.SIGKILL,)
    ), said
    assert "Traceback" not in said
    if sign == signal.SIGINT:
        # after some seconds progress is told too
        *told, said = said.splitlines()
        assert all(line.startswith("symkin: points, ") for line in told)
        assert said.startswith("symkin: interrupted")
        assert all(
            words in said
            for words in (str(tmp_path / "cut"), "chunks are kept", "the same command goes on")
        )
    wait_for(lambda: not any(os.path.exists(f"/proc/{pid}") for pid in workers))
    done = marks(tmp_path / "cut")
    assert 2 <= done < 30
    swept = sweep(PLATFORM, GRID, tmp_path / "cut", workers=0, chunk=CHUNK)
    assert swept.computed == 30 - done
    assert same_files(whole, tmp_path / "cut")


@pytest.mark.slow
def test_a_killed_worker_is_replaced(whole, tmp_path):
    """kill -9 of a worker process while others work: the pool is built anew and the files are the
    same.
    """
    killed = []

    def kill(done, total):
        if done and not killed:
            killed.append(multiprocessing.active_children()[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    swept = sweep(PLATFORM, GRID, tmp_path / "s", workers=2, chunk=CHUNK, progress=kill)
    assert killed
    assert swept.computed == len(GRID["leg1"])
    assert same_files(whole, tmp_path / "s")
    assert not multiprocessing.active_children()


def dies(job, index):
    os._exit(1)


@pytest.mark.slow
def test_work_that_kills_its_workers_is_given_up(monkeypatch):
    """Chunks that end every worker stop the sweep with a sentence, and leave no process."""
    monkeypatch.setattr(inside.executors, "_MOST_LOSSES", 1)
    with pytest.raises(InputError, match="workers end abruptly"), local_crew(1) as crew:
        list(crew.results(dies, b"", range(3)))
    wait_for(lambda: not multiprocessing.active_children())


def test_a_worker_that_runs_a_script_without_guard_ends_silently(monkeypatch):
    """A worker that is being started imports the script, and a sweep in it starts no workers: it
    leaves without a traceback, and the sentence of the first process alone is seen.
    """
    monkeypatch.setattr(multiprocessing.current_process(), "_inheriting", True, raising=False)
    with pytest.raises(SystemExit), local_crew(1):
        pass


def same(job, index):
    return index


def test_chunks_under_way_are_bounded():
    """No more chunks are asked for than are under way, however many there are."""
    asked = []
    chunks = (asked.append(i) or i for i in range(50))
    for count, _ in enumerate(Crew(Here(), 3).results(same, b"", chunks), start=1):
        assert len(asked) <= count + 3
    assert count == 50


# --- Dask -----------------------------------------------------------------------------------------


@pytest.fixture
def cluster():
    """A real scheduler and two worker processes on loopback."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=None
    ) as made:
        yield made


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_dask_gives_the_same_files_though_a_worker_is_killed(whole, tmp_path, cluster):
    """Two worker processes of a scheduler on loopback, one of them killed on the way: the same
    files.
    """
    killed = []

    def kill(done, total):
        if done and not killed:
            killed.append(next(iter(cluster.workers.values())).pid)
            os.kill(killed[0], signal.SIGKILL)

    swept = sweep(
        PLATFORM, GRID, tmp_path / "s", dask=cluster.scheduler_address, chunk=CHUNK, progress=kill
    )
    assert killed
    assert swept.computed == len(GRID["leg1"])
    assert same_files(whole, tmp_path / "s")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_dask_addresses_that_do_not_answer(tmp_path, monkeypatch):
    """A port that nobody serves, and text that is no address, are sentences."""
    pytest.importorskip("distributed")
    monkeypatch.setattr(inside.executors, "_PATIENCE_S", 1.0)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    for address in (f"tcp://127.0.0.1:{port}", "nonsense://here"):
        with pytest.raises(InputError, match="no Dask scheduler answers"):
            sweep(PLATFORM, {"leg1": [140.0]}, tmp_path / "s", dask=address)
    assert not (tmp_path / "s").exists()


@pytest.fixture
def processes(tmp_path):
    """A scheduler and a worker as processes of their own: the scheduler and its address."""
    pytest.importorskip("distributed")
    file, quiet = (
        str(tmp_path / "scheduler.json"),
        {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL},
    )
    run = [sys.executable, "-m"]
    options = ["--scheduler-file", file, "--no-dashboard"]
    scheduler = subprocess.Popen(
        [*run, "distributed.cli.dask_scheduler", *options, "--port", "0", "--host", "127.0.0.1"],
        **quiet,
    )
    worker = subprocess.Popen(
        [*run, "distributed.cli.dask_worker", *options, "--nworkers", "1", "--nthreads", "1"],
        **quiet,
    )
    end = time.monotonic() + 60
    while not (tmp_path / "scheduler.json").exists() and time.monotonic() < end:
        time.sleep(0.1)
    yield (
        scheduler,
        json.loads((tmp_path / "scheduler.json").read_text(encoding="utf-8"))["address"],
    )
    for process in (worker, scheduler):
        process.kill()
        process.wait()


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_killed_dask_scheduler_is_one_sentence(whole, tmp_path, processes, monkeypatch, capfd):
    """What Dask's threads say of it is not shown, and the same sweep goes on elsewhere, to the same
    files.
    """
    monkeypatch.setattr(inside.executors, "_PATIENCE_S", 30.0)
    scheduler, address = processes

    def kill(done, total):
        if done:
            scheduler.kill()

    with pytest.raises(
        InputError, match=r"the Dask scheduler at .* has ended.*what is done is kept"
    ):
        sweep(PLATFORM, GRID, tmp_path / "s", dask=address, chunk=CHUNK, progress=kill)
    assert "Traceback" not in capfd.readouterr().err
    sweep(PLATFORM, GRID, tmp_path / "s", workers=0, chunk=CHUNK)
    assert same_files(whole, tmp_path / "s")


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("ProcessPoolExecutor", ImportError("no semaphores here")),
        ("ProcessPoolExecutor", OSError(38, "Function not implemented")),
        ("submit", BlockingIOError(11, "Resource temporarily unavailable")),
        ("submit", RuntimeError("can't start new thread")),
    ],
)
def test_a_system_without_processes_is_told_and_what_helps(monkeypatch, tmp_path, name, error):
    """Semaphores, threads or processes that the system does not give."""

    def refuse(*_, **__):
        raise error

    where = inside.executors if name != "submit" else inside.executors.ProcessPoolExecutor
    monkeypatch.setattr(where, name, refuse)
    with pytest.raises(InputError, match=r"worker processes cannot be started .* \(--workers 0\)"):
        sweep(symkin.load("four_bar"), {"crank": [60.0, 70.0]}, tmp_path / "map", workers=2)
