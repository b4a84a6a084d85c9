"""Cold processes: `import symkin` and `symkin modes zhao2000`, wall seconds, medians of fresh interpreters.

python benchmarks/startup.py [--repeats 9]
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import time

COMMANDS = {
    "python -c pass": ["-c", "pass"],
    "import symkin": ["-c", "import symkin"],
    "symkin list": ["-m", "symkin", "list"],
    "symkin modes zhao2000": ["-m", "symkin", "modes", "zhao2000"],
    "symkin modes zhang2009": ["-m", "symkin", "modes", "zhang2009"],
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=9)
    repeats = parser.parse_args().repeats
    for name, arguments in COMMANDS.items():
        times = [seconds(arguments) for _ in range(repeats + 1)][1:]
        print(f"{name:24} median {statistics.median(times):.3f} s   min {min(times):.3f}   max {max(times):.3f}")


def seconds(arguments: list[str]) -> float:
    begin = time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - begin


if __name__ == "__main__":
    main()
