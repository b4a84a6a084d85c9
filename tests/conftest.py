"""One hypothesis profile for all tests, the same examples each time on any machine, and cache
folders of the tests' own.
"""

import gc
import os
import signal
from functools import partial

# before NumPy is loaded: tests run side by side, a process a core
os.environ.setdefault("OMP_NUM_THREADS", "1")

import pytest
from hypothesis import HealthCheck, settings

from helpers import inside, warm_child

settings.register_profile(
    "symkin",
    derandomize=True,
    deadline=None,
    max_examples=30,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("symkin")


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """What is collected lives as long as the process: looking for garbage in it takes a sixth of
    the time.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """What is long is slow too: `-m "not slow"` leaves out both."""
    for item in items:
        if item.get_closest_marker("long"):
            item.add_marker("slow")


@pytest.fixture(scope="session")
def shared_place(tmp_path_factory):
    """A folder of this run, the same for all its workers."""
    base = tmp_path_factory.getbasetemp()
    return base.parent if "PYTEST_XDIST_WORKER" in os.environ else base


@pytest.fixture(scope="session", autouse=True)
def _shared_folders_of_c(shared_place):
    """Folders of C that are not committed are written once for all workers of a run."""
    os.environ["SYMKIN_FOLDERS"] = str(shared_place / "folders")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache folder of the test's own."""
    monkeypatch.setenv("SYMKIN_CACHE", str(tmp_path))
    return tmp_path


@pytest.fixture
def heard_interrupts():
    """SIGINT interrupts this process and those it starts, though the tests run in a shell's
    background, where it is ignored.
    """
    former = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, former)


@pytest.fixture(autouse=True)
def no_lines_on_slow_machines(monkeypatch):
    """Commands say what they do after some seconds, which tests that want an empty stderr need not
    wait for.
    """
    monkeypatch.setattr(inside.progress, "_FIRST", 600.0)


@pytest.fixture(autouse=True, scope="session")
def one_mujoco():
    """MJCF files are compiled by forks of one process, which has loaded MuJoCo: a process for each
    file takes 0.3 s.
    """
    if not hasattr(os, "fork"):
        yield
        return
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            inside.mjcf, "answer_of", partial(warm_child.answer_of, inside.child.answer_of)
        )
        yield


@pytest.fixture
def own_mujoco(monkeypatch):
    """Each MJCF file is compiled by a process of its own, as outside the tests."""
    monkeypatch.setattr(inside.mjcf, "answer_of", inside.child.answer_of)
