"""Files of generic roots: those of the shipped mechanisms lie in `symkin/homotopy/data/starts`,
others in the cache folder (SYMKIN_CACHE, else the platform's). Their names are hashes of the rows'
instructions and constants.
"""

from __future__ import annotations

import hashlib
import io
import zlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from zipfile import BadZipFile

import casadi as ca
import numpy as np

from symkin.closure.expression_graph import instructions
from symkin.computed_once import computing, lru_cache
from symkin.homotopy.algebraic import AlgebraicSystem
from symkin.homotopy.monodromy import Fibre
from symkin.homotopy.symmetry import Orbits, Symmetries
from symkin.numeric.cache_folder import cache_folder, discard, keep, read_kept

SHIPPED = Path(__file__).resolve().parent / "data" / "starts"
_VERSION = 6
_SEARCHES = 5
"""Version of the searches: what one of another version found in the cache folder, or why it found
nothing, is not believed.
"""
_SATISFIED = 1e-8
"""Largest row, over the size, that a kept root may leave, and least difference of two roots. Rows
of a root far from real ones have derivatives of 1e4 and more; theirs are divided by these.
"""
_MIRRORED = 1e-5
"""Difference of a root and the image of another that is the same one."""

Found = tuple[Fibre | None, str]
"""The roots, or None and the reason why there are none."""


def kept_or_computed(key: str, system: AlgebraicSystem, compute: Callable[[], Found]) -> Found:
    """The roots that are kept under a key, or those that are computed now and then kept; one
    process waits for another.
    """
    kept = read_start_file(key, system)
    if kept is not None:
        return kept
    with computing((__name__, key)):
        kept = read_start_file(key, system)
        if kept is None:
            kept = compute()
            keep(cache_folder(), key, ".npz", content_of(*kept))
    return kept


@lru_cache(maxsize=256)
def closure_key(system: AlgebraicSystem, search: str = "") -> str:
    """Hash of the block's rows: instructions, places and constants; and of what searches its roots,
    where another `search` than the block's own does.
    """
    function = ca.Function("rows", [system.z, system.k], [system.rows], {"cse": True})
    return hash_of(function, f"{system.projective} {[c.kind for c in system.unknowns]} ({search})")


def hash_of(function: ca.Function, text: str) -> str:
    digest = hashlib.sha256(f"{_VERSION} {text}".encode())
    for op, inputs, outputs, number in instructions(function):
        constant = f"{number:.12g}" if op == ca.OP_CONST else ""
        digest.update(f"{op} {inputs} {outputs} {constant};".encode())
    return digest.hexdigest()[:32]


def read_start_file(key: str, system: AlgebraicSystem) -> tuple[Fibre | None, str] | None:
    """A kept start whose roots satisfy the rows, or the reason why there is none; anything else is
    removed.
    """
    with suppress(OSError):
        shipped = _start_in((SHIPPED / f"{key}.npz").read_bytes(), system)
        if shipped is not None:
            return shipped
    for place, content in read_kept(cache_folder(), key, ".npz"):
        kept = _start_in(content, system, searched=True)
        if kept is not None:
            return kept
        discard(place)
    return None


def _start_in(
    content: bytes, system: AlgebraicSystem, *, searched: bool = False
) -> tuple[Fibre | None, str] | None:
    """What a file says, or None where it holds no start of this system; or, of a reason and of one
    that was `searched` here, where another version did.
    """
    try:
        with np.load(io.BytesIO(content)) as data:
            if (searched or str(data["reason"])) and data["searches"] != _SEARCHES:
                return None
            if str(data["reason"]):
                return None, str(data["reason"])
            kept = Fibre(
                z=data["z"],
                k=data["k"],
                orbits=data["orbits"],
                evidence=float(data["evidence"]),
                loops=0,
                seed=int(data["seed"]),
                mirrors=_mirrors_in(data),
            )
        with np.errstate(all="ignore"):
            return (kept, "") if _is_start(system, kept) else None
    except (
        OSError,
        ValueError,
        TypeError,
        KeyError,
        IndexError,
        EOFError,
        MemoryError,
        BadZipFile,
        zlib.error,
    ):
        return None


def _is_start(system: AlgebraicSystem, start: Fibre) -> bool:
    """Whether the roots satisfy the rows, differ from each other, and are carried to each other as
    their mirrors say.
    """
    n = start.z.shape[1]
    fits = (
        start.z.shape == (system.width, n)
        and start.k.shape == (system.k.shape[0],)
        and start.orbits.shape == (n,)
    )
    if not fits or n == 0:
        return False
    rows, derivatives = system.linearise(start.z, np.repeat(start.k[:, None], n, axis=1))
    steepness = np.max(np.abs(derivatives), axis=(1, 2))
    if not np.max(np.max(np.abs(rows), axis=1) / np.maximum(steepness, 1.0)) < _SATISFIED:
        return False
    features = system.features(start.z)
    mixed = features @ np.random.default_rng(0).normal(size=features.shape[1])
    if not np.all(np.abs(mixed[:, None] - mixed)[np.triu_indices(n, 1)] > _SATISFIED):
        return False
    if start.mirrors is None:
        return True
    mirrored = system.features(start.mirrors.unfold(start.z[:, start.mirrors.first]))
    return bool(np.max(np.abs(mirrored - features), initial=0.0) < _MIRRORED)


def _mirrors_out(mirrors: Orbits) -> dict[str, np.ndarray]:
    maps = {"matrices": mirrors.symmetries.matrices, "shifts": mirrors.symmetries.shifts}
    return maps | {"labels": mirrors.labels, "first": mirrors.first, "maps": mirrors.maps}


def _mirrors_in(data: Mapping[str, np.ndarray]) -> Orbits | None:
    if "matrices" not in data:
        return None
    return Orbits(
        Symmetries(data["matrices"], data["shifts"]),
        data["labels"],
        data["first"],
        data["maps"],
        True,
    )


def content_of(start: Fibre | None, reason: str) -> bytes:
    """A file of a start, or of the reason why there is none."""
    content: dict[str, np.ndarray | float | str] = {"reason": reason, "searches": _SEARCHES}
    if start is not None:
        content |= {
            "z": start.z,
            "k": start.k,
            "orbits": start.orbits,
            "evidence": start.evidence,
            "seed": start.seed,
        }
        content |= {} if start.mirrors is None else _mirrors_out(start.mirrors)
    file = io.BytesIO()
    np.savez(file, **content)  # type: ignore[arg-type]
    return file.getvalue()
