"""Random mechanisms through every verb of the command line, each answer held against a closure of
the benchmark's own.

    python tests/campaigns/random_mechanisms.py [--count 2000] [--seed 0] [--workers 1] [--limit 20]
        [-o FOLDER] [--only INDEX]

Each mechanism has a process of its own. Counted are tracebacks (and warnings, broken JSON,
undocumented statuses), lost modes (a regular mode that random starts find and a proved list, or one
of probability one, lacks), silent wrong answers (what does not close, Jacobians that differ from
differences of the closure, C that does not compile), timeouts and crashes. Every finding names the
file and the command that shows it. The same seed gives the same mechanisms; finished ones are kept
in FOLDER and not run again. Exit status 1 where anything was found.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from campaigns.children import Ended, Work, run_each

KINDS = ("traceback", "lost mode", "wrong answer", "timeout", "crash")
COMPILED_SHARE, SWEPT_SHARE = 10, 12
"""One mechanism in so many has its C compiled, or is swept."""
NOTHING: dict[str, Any] = {"statuses": {}, "times": {}, "refusals": [], "compared": 0, "sampled": 0}
"""What a mechanism without an answer adds to the counts."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument(
        "--limit", type=float, default=20.0, help="Seconds of CPU that a mechanism may take."
    )
    parser.add_argument(
        "--only", type=int, nargs="*", help="Indices to run, again if they are kept."
    )
    parser.add_argument("-o", "--output", type=Path, help="Folder of mechanism files and results.")
    parser.add_argument(
        "--refusals", action="store_true", help="Print what was refused, by message."
    )
    options = parser.parse_args()
    folder = options.output or Path(tempfile.mkdtemp(prefix="random_mechanisms_"))
    folder.mkdir(parents=True, exist_ok=True)
    results = run_all(
        folder, options.count, options.seed, options.workers, options.limit, options.only
    )
    print(report(results, options.seed, folder, refusals=options.refusals))
    return int(any(r["findings"] for r in results))


def run_all(
    folder: Path, count: int, seed: int, workers: int, limit: float, only: list[int] | None = None
) -> list[dict[str, Any]]:
    """Results of all mechanisms, those kept in the folder included, in order."""
    prepare(folder)
    kept = {} if only is not None else kept_results(folder, seed)
    wanted = [i for i in (range(count) if only is None else only) if i not in kept]

    found = dict(kept)
    for ended in run_each(wanted, _work(folder, seed), max(1, workers), limit):
        result = _result(ended, limit)
        (folder / f"result_{seed}_{ended.task}.json").write_text(json.dumps(result))
        found[ended.task] = result
        for finding in result["findings"]:
            print(f"{finding['kind']}: {finding['text']}\n    {finding['command']}", flush=True)
    return [found[i] for i in sorted(found) if only is not None or i < count]


def prepare(folder: Path) -> None:
    """Settings of all children, and imports that they share: one thread, a cache of their own."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    os.environ["SYMKIN_CACHE"] = str(folder / "cache")
    from helpers.inside import certify_batch, continuation, main  # noqa: F401
    from oracle import mechanism_checks  # noqa: F401
    from symkin import track  # noqa: F401


def kept_results(folder: Path, seed: int) -> dict[int, dict[str, Any]]:
    results = [json.loads(path.read_text()) for path in folder.glob(f"result_{seed}_*.json")]
    return {r["index"]: r for r in results}


def _work(folder: Path, seed: int) -> Work:
    """What a process does with the mechanism of an index: it sends the command that it runs, then
    its answer.
    """
    import numpy as np

    from campaigns.random_files import random_file
    from oracle.mechanism_checks import Checks

    def work(index: int, send: Callable[[Any], None]) -> None:
        file = folder / f"m_{seed}_{index}.toml"
        checks = None
        try:
            data = random_file(np.random.default_rng([seed, index]))
            numbers = (seed, index, 1)
            checks = Checks(
                file,
                data,
                numbers,
                index % COMPILED_SHARE == 0,
                index % SWEPT_SHARE == 0,
                stage=send,
            )
            checks.all()
            findings = [asdict(f) for f in checks.findings]
        except BaseException:
            findings = [asdict(f) for f in checks.findings] if checks else []
            findings.append(
                {
                    "kind": "crash",
                    "text": "the benchmark: " + traceback.format_exc()[-900:],
                    "command": str(file),
                }
            )
        about = NOTHING if checks is None else {key: getattr(checks, key) for key in NOTHING}
        send({"findings": findings, **about, "seconds": time.process_time()})

    return work


def _result(ended: Ended, limit: float) -> dict[str, Any]:
    """The answer of a process, or that it has none."""
    last = ended.sent[-1] if ended.sent else "making the file"
    if isinstance(last, dict):
        return last | {"index": ended.task}
    finding = {
        "kind": "timeout" if ended.late else "crash",
        "text": str(ended.fault),
        "command": last,
    }
    return NOTHING | {"findings": [finding], "seconds": limit, "index": ended.task}


def report(
    results: list[dict[str, Any]], seed: int, folder: Path, *, refusals: bool = False
) -> str:
    found = Counter(f["kind"] for r in results for f in r["findings"])
    statuses: Counter[str] = Counter()
    messages: Counter[str] = Counter()
    times: Counter[str] = Counter()
    for r in results:
        times.update(r["times"])
        statuses.update(r["statuses"])
        messages.update(r["refusals"])
    seconds = sorted(r["seconds"] for r in results)
    lines = [
        f"{f['kind']}: {f['text']}\n    {f['command']}" for r in results for f in r["findings"]
    ]
    lines += [f"  {n:5d}  {text}" for text, n in messages.most_common()] if refusals else []
    lines += [
        f"statuses of commands: {', '.join(f'{key}: {n}' for key, n in sorted(statuses.items()))}",
        f"lists of modes held against random starts: {sum(r['compared'] for r in results)} "
        f"complete ones; "
        f"{sum(r['sampled'] for r in results)} say that they may not be",
        f"seconds by verb: "
        f"{', '.join(f'{key} {seconds:.1f}' for key, seconds in times.most_common())}",
        f"seconds of CPU: {sum(seconds):.0f} in all, {sum(seconds) / max(1, len(seconds)):.1f} a "
        f"mechanism, longest {seconds[-1] if seconds else 0:.0f}",
        f"seed {seed}, {len(results)} mechanisms: "
        + ", ".join(f"{found[kind]} {_plural(kind, found[kind])}" for kind in KINDS)
        + f"; files in {folder}",
    ]
    return "\n".join(lines)


def _plural(kind: str, count: int) -> str:
    return kind if count == 1 else {"crash": "crashes"}.get(kind, f"{kind}s")


if __name__ == "__main__":
    sys.exit(main())
