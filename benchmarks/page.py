"""Frames a second of the page while a slider is dragged, in Chromium with software rendering.

    python benchmarks/page.py [MECHANISM ...] [--seconds 5]

The first slider of each page is dragged to and fro by the mouse. Told are the median interval
between frames, the script of a frame (wall time, median and the lowest tenth, which other work on
the machine delays least), and the processor time of the page's thread over the number of frames.
60 frames a second need less than 16 ms of each.
"""

from __future__ import annotations

import argparse
import math
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

import symkin

MECHANISMS = ("zhao2000", "ren2008", "five_bar")
SOFTWARE = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
COMES_UP = 60_000
"""Milliseconds within which a page is ready."""
SETTLES = 2_000
"""Milliseconds until small views are drawn and sliders marked."""
SHOWN = "document.querySelector('#modes-text').innerText.includes('at these values')"
WAY = 0.1
"""Share of a slider's width by which it is dragged to both sides."""
PERIOD = 2.0
"""Seconds of a movement to and fro."""
RECORDER = """() => {
  window.frames_ = [];
  const ask = window.requestAnimationFrame;
  window.requestAnimationFrame = (step) => ask((now) => {
    const begin = performance.now();
    step(now);
    window.frames_.push([now, performance.now() - begin]);
  });
}"""
"""Notes when each frame began and how long its script took."""


def dragged(page: Any, seconds: float) -> dict[str, float]:
    """Drag the first slider for some seconds; what its frames took."""
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")
    slider = page.locator("#inputs input[type=range]").first
    box = slider.bounding_box()
    low, high, value = (float(slider.get_attribute(key) or 0) for key in ("min", "max", "value"))
    value = float(slider.input_value())
    x = box["x"] + box["width"] * (value - low) / (high - low)
    y = box["y"] + 0.5 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.evaluate(RECORDER)
    before, begin = _metrics(session), time.perf_counter()
    while (gone := time.perf_counter() - begin) < seconds:
        page.mouse.move(x + WAY * box["width"] * math.sin(2 * math.pi * gone / PERIOD), y)
    after, (times, script) = _metrics(session), np.array(page.evaluate("window.frames_")).T
    page.mouse.up()
    return {
        "frames": len(times),
        "apart": float(np.median(np.diff(times))),
        "script": float(np.median(script)),
        "least": float(np.quantile(script, 0.1)),
        "processor": 1e3 * (after["ThreadTime"] - before["ThreadTime"]) / len(times),
    }


def _metrics(session: Any) -> dict[str, float]:
    found = session.send("Performance.getMetrics")["metrics"]
    return {metric["name"]: metric["value"] for metric in found}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("mechanisms", nargs="*", default=MECHANISMS)
    parser.add_argument("--seconds", type=float, default=5.0)
    asked = parser.parse_args()
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=list(SOFTWARE)
        )
        for name in asked.mechanisms:
            file = Path(folder) / "page.html"
            symkin.view(symkin.load(name)).save(file)
            page = browser.new_page(viewport={"width": 1400, "height": 900})
            page.goto(file.as_uri())
            page.wait_for_function("document.documentElement.dataset.ready", timeout=COMES_UP)
            page.wait_for_function(SHOWN, timeout=COMES_UP)
            page.wait_for_timeout(SETTLES)
            took = dragged(page, asked.seconds)
            print(
                f"{name:12} {took['frames']:5.0f} frames, {took['apart']:6.1f} ms apart; script of "
                f"a frame {took['script']:5.1f} ms (10 %: {took['least']:5.1f}), processor of the "
                f"page's thread {took['processor']:5.1f} ms"
            )
            page.close()


if __name__ == "__main__":
    main()
