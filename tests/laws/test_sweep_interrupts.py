"""Ctrl-C within a call of Zarr waits for it, and processes that are being started do not hear
it.
"""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import symkin
from helpers.inside import (
    Job,
    Store,
    compute_chunk,
    interrupts_held,
    interrupts_kept_from_children,
    make_plan,
    make_space,
    open_store,
)

pytestmark = [
    pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="needs the signals of POSIX"),
    pytest.mark.usefixtures("heard_interrupts"),
]


def ctrl_c():
    os.kill(os.getpid(), signal.SIGINT)


def test_a_chunk_is_written_whole_when_ctrl_c_comes_meanwhile(tmp_path, monkeypatch):
    """Ctrl-C in the middle of the first of a chunk's arrays: the chunk and its mark are written,
    then the sweep is interrupted. (Cut short, Zarr's thread went on into the end of the process and
    complained there.)
    """
    local = pytest.importorskip("zarr.storage._local")
    mechanism = symkin.load("zhao2000")
    plan = make_plan(
        make_space(mechanism, {"op": np.linspace(90, 120, 4)}, at=[81.6, 202.8, 330.6, 105.2]),
        chunk=4,
    )
    finder = plan.finder()
    pinned = plan.pinned(finder)
    store: Store = open_store(tmp_path / "s", plan, pinned, finder.bound)
    assert store.is_untouched
    arrays = compute_chunk(Job(plan, pinned).packed(), 0)
    put, slow = local._put, []

    def interrupted(*args, **kwargs):
        if not slow:
            slow.append(True)
            ctrl_c()
            time.sleep(0.2)
        return put(*args, **kwargs)

    monkeypatch.setattr(local, "_put", interrupted)
    with pytest.raises(KeyboardInterrupt):
        store.write(0, arrays)
    assert slow
    assert store.done().all()
    assert not store.is_untouched
    assert (store.counts(0) == arrays["count"]).all()


@interrupts_held()
def interrupted_once(reached):
    ctrl_c()
    reached.append("end")


@interrupts_held()
def interrupted_twice(reached):
    ctrl_c()
    reached.append("middle")
    ctrl_c()
    time.sleep(1)
    reached.append("end")


def test_interrupts_wait_once():
    """The block ends before the first Ctrl-C is heard; the second is heard at once; afterwards all
    is as before.
    """
    former = signal.getsignal(signal.SIGINT)
    for function, expected in ((interrupted_once, ["end"]), (interrupted_twice, ["middle"])):
        reached = []
        with pytest.raises(KeyboardInterrupt):
            function(reached)
        assert reached == expected
        assert signal.getsignal(signal.SIGINT) is former


def test_other_threads_hold_nothing():
    """A sweep in a thread leaves the handlers of the main one alone."""
    found = []

    def work():
        with interrupts_held():
            found.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [signal.getsignal(signal.SIGINT)]


@interrupts_kept_from_children()
def interrupted_while_starting(reached):
    signal.raise_signal(signal.SIGINT)
    reached.append("end")


def test_started_processes_do_not_hear_ctrl_c():
    """A process started in the block lives through SIGINT; one that comes to this process meanwhile
    is heard after it.
    """
    with interrupts_kept_from_children():
        child = subprocess.Popen(
            [
                sys.executable,
                "-c",
                "import time; print('up', flush=True); time.sleep(0.5); print('alive')",
            ],
            stdout=subprocess.PIPE,
            text=True,
        )
    assert child.stdout.readline() == "up\n"
    child.send_signal(signal.SIGINT)
    assert child.communicate(timeout=20)[0] == "alive\n"
    reached = []
    with pytest.raises(KeyboardInterrupt):
        interrupted_while_starting(reached)
    assert reached == ["end"]
