"""The pictures of a tutorial: what each of its commands with `--plot` draws, below that command."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

_MACHINE = re.compile(r"^```toml\n# (\w+\.toml)\n(.*?)^```", re.M | re.S)
_SESSION = re.compile(r"^```console\n(.*?)^```\n", re.M | re.S)
_COMMAND = re.compile(r"^\$ (symkin .*--plot (\w+)\.png.*)$", re.M)


def draw_pictures(pages: list[Path], folder: Path) -> None:
    """Run the commands that draw, with the machines that the pages describe, and keep
    PAGE_PICTURE.png of each.
    """
    folder.mkdir()
    texts = {page.stem: page.read_text(encoding="utf-8") for page in pages}
    with tempfile.TemporaryDirectory() as place:
        for text in texts.values():
            for name, machine in _MACHINE.findall(text):
                Path(place, name).write_text(machine, encoding="utf-8")
        for page, text in texts.items():
            for command, picture in _COMMAND.findall(text):
                words = [sys.executable, "-m", "symkin", *shlex.split(command)[1:]]
                done = subprocess.run(words, cwd=place, check=False, capture_output=True, text=True)
                drawn = Path(place, f"{picture}.png")
                if not drawn.exists():  # the status tells nothing: a path may stop, with status 3
                    raise RuntimeError(
                        f"{page}: {command} drew nothing (status {done.returncode}): "
                        f"{done.stderr.strip()}"
                    )
                shutil.move(drawn, folder / f"{page}_{picture}.png")


def with_pictures(page: str, text: str, folder: Path) -> str:
    """The page's text with each picture below the block of its command."""

    def drawn(block: re.Match[str]) -> str:
        shown = [
            f"\n```{{image}} /{folder.parent.name}/{folder.name}/{page}_{picture}.png\n"
            f":alt: What {command} draws\n```\n"
            for command, picture in _COMMAND.findall(block[1])
            if (folder / f"{page}_{picture}.png").exists()
        ]
        return block[0] + "".join(shown)

    return _SESSION.sub(drawn, text)
