"""What commands say of long work off a terminal: lines on stderr, stdout as it is."""

import io
import json
import logging
import re
import subprocess
import sys
import time

from helpers import inside
from helpers.inside import progress


def _lines(capsys, monkeypatch, work):
    monkeypatch.setattr(progress, "_FIRST", 0.05)
    with progress.progress_bar("solutions") as show:
        work(show)
    return capsys.readouterr()


def test_short_work_says_nothing(capsys, monkeypatch):
    """A word comes after some seconds only."""
    monkeypatch.setattr(progress, "_FIRST", 5.0)
    with progress.progress_bar("solutions") as show:
        show(1, 2)
    assert capsys.readouterr() == ("", "")


def test_long_work_says_what_is_done_and_how_much_of_it(capsys, monkeypatch):
    """What symkin logs, with the share that is done and the time; nothing on stdout."""

    def work(show):
        logging.getLogger("symkin.homotopy").info("generic solutions are searched")
        show(3, 10)
        time.sleep(0.5)

    out, err = _lines(capsys, monkeypatch, work)
    assert out == ""
    assert re.fullmatch(r"symkin: generic solutions are searched, 3 of 10 \(\d+ s\)\n", err)


def test_the_log_is_left_as_it_was(capsys, monkeypatch):
    logger = logging.getLogger("symkin")
    before = logger.level, list(logger.handlers)
    _lines(capsys, monkeypatch, lambda _: None)
    assert (logger.level, logger.handlers) == before


CODE = f"""
import sys, time
import {inside.where("progress")} as progress
import {inside.where("modes_module")} as modes
progress._FIRST = 0.05
search = modes._of_machine
modes._of_machine = lambda *a: (time.sleep(0.4), search(*a))[1]
from {inside.where("main")} import main
main(["modes", "zhang2009", "--json"])
"""


def test_json_stays_alone_on_stdout():
    """A command that takes longer than the first line's time: the line is on stderr, stdout is one
    object.
    """
    done = subprocess.run(
        [sys.executable, "-c", CODE], capture_output=True, text=True, timeout=120, check=False
    )
    assert json.loads(done.stdout)["mechanism"] == "zhang2009"
    assert done.stderr.startswith("symkin: ")
    assert done.returncode == 0


def test_a_bar_on_a_terminal_counts(monkeypatch):
    """What is done of how much, beside the words for it; the rate is of what is done since."""

    class Terminal(io.StringIO):
        def isatty(self):
            return True

    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    with progress.progress_bar("points") as show:
        show(2, 10)
        show(5, 10)
    assert "points" in terminal.getvalue()
    assert "5/10" in terminal.getvalue()
