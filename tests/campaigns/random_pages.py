"""Pages of random machines in a browser: do they come up, and show the modes that `modes` lists at
other values too?

    python tests/campaigns/random_pages.py [--count 100] [--seed 0] [-o FOLDER]

Machines are those of `random_graphs.py`, with sliders for coordinates that decide all others. Each
page is opened in Chromium by Playwright. It must come up without an error, and in 30 s. At the
start and at two places to which it then goes, its modes are those of `modes`. "lost": the page says
that it follows all complex solutions and has another list than `modes`, which is complete; "short":
it says that modes may be missing. Exit status 1 for errors and lost modes.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import symkin
from campaigns.random_graphs import Drawing, chosen_values

COMES_UP = 30_000
"""Milliseconds within which a page is ready."""
NEAR = 0.1
"""How far the second and third place are from the one before: radians, and shares of the size."""
COMPLETE = ("proved", "probability one")


def judged(
    page: Any, mechanism: symkin.Mechanism, given: dict[str, float], rng: np.random.Generator
) -> tuple[str, object]:
    """ "same", "short", "lost", or "sampled" where there is no complete list to compare with."""
    verdict, told = "same", []
    for place in range(3):
        if place:
            given = {
                name: value + NEAR * rng.uniform(-1, 1) * _unit(mechanism, name)
                for name, value in given.items()
            }
            if not page.evaluate("values => symkin.set(values).reached", given):
                break
        shown, words = page.evaluate(
            "[symkin.modes().map(mode => mode.joints), document.querySelector('#modes').innerText]"
        )
        page.wait_for_function("!document.querySelector('#modes').innerText.includes('Finding')")
        found = symkin.modes(mechanism, given=given)
        told.append((len(shown), len(found)))
        if found.completeness not in COMPLETE:
            verdict = "sampled" if verdict == "same" else verdict
        elif len(shown) != len(found):
            verdict = (
                "short"
                if any(
                    word in words for word in ("may be missing", " of the ", "too many", "agree")
                )
                else "lost"
            )
            if verdict == "lost":
                break
    return verdict, told


def _unit(mechanism: symkin.Mechanism, name: str) -> float:
    c = next(c for c in mechanism.coordinates if c.name == name)
    return mechanism.angle_out(1.0) if c.is_angular else mechanism.characteristic_length


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("-o", "--output", type=Path)
    options = parser.parse_args()
    folder = options.output or Path(tempfile.mkdtemp(prefix="random_pages_"))
    folder.mkdir(parents=True, exist_ok=True)
    print(f"seed {options.seed}, files in {folder}")
    counts: Counter[str] = Counter()
    with sync_playwright() as playwright:
        arguments = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=arguments
        )
        for index in range(options.count):
            rng = np.random.default_rng([options.seed, index])
            path = folder / f"{index}.toml"
            path.write_text(Drawing(rng).grow())
            chosen = chosen_values(path, rng)
            if chosen is None:
                counts["not closed"] += 1
                continue
            verdict, about = _opened(browser, path, chosen[0], rng)
            counts[verdict] += 1
            print(index, verdict, about, flush=True)
        browser.close()
    print(dict(counts))
    return int(bool(counts["lost"] or counts["error"]))


def _opened(
    browser: Any, path: Path, given: dict[str, float], rng: np.random.Generator
) -> tuple[str, object]:
    try:
        mechanism = symkin.load(path)
        symkin.view(mechanism, given=given).save(path.with_suffix(".html"))
    except symkin.SymkinError as error:
        return "refused", str(error)
    page, errors = browser.new_page(), list[str]()
    page.on("pageerror", lambda error: errors.append(str(error)))
    try:
        page.goto(path.with_suffix(".html").resolve().as_uri(), timeout=COMES_UP)
        page.wait_for_selector("html[data-ready]", state="attached", timeout=COMES_UP)
        verdict, about = judged(page, mechanism, given, rng)
    except Exception as error:
        verdict, about = "error", repr(error)[:300]
    finally:
        page.close()
    return ("error", errors) if errors else (verdict, about)


if __name__ == "__main__":
    sys.exit(main())
