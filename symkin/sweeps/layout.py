"""The empty arrays of a sweep's folder: names, dimensions, chunks, attributes, and the coordinates
of the points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from symkin.assembly.mode_table import joint_labels
from symkin.model.names import is_device
from symkin.quiet import warnings_ignored
from symkin.sweeps.plan import Plan
from symkin.sweeps.quantities import ALL_NAMES

_MODE_CHUNK, _MODE_SHARD = 8, 64
"""Modes in one chunk of an array, and in one file, which has several chunks."""
_COMPRESSION_LEVEL = 1
"""Level of Zstandard with which arrays over the points are made: its own default makes files 2 %
smaller in twice the time.
"""
_SAMPLE_DIMENSION = "point"
_DIMENSIONS = (
    "mode",
    "axis",
    "component",
    "joint",
    "joint_units",
    "named_point",
    "chunk",
    "done",
    "digest",  # of earlier layouts
    _SAMPLE_DIMENSION,
)
RESERVED = ALL_NAMES.union(_DIMENSIONS)
"""Names of arrays and dimensions: a swept joint of such a name is stored as `joint.NAME`."""


def labels(names: Sequence[str]) -> list[str]:
    """Names of arrays for swept names: those that collide or that no path can hold are changed."""
    found: list[str] = []
    for name in names:
        clean = "".join(c if c.isalnum() or c in "._-" else "_" for c in name)
        plain = clean == name and name not in RESERVED and name[0].isalpha() and not is_device(name)
        label = name if plain else f"joint.{clean}"
        while label in found:
            label += "_"
        found.append(label)
    return found


def consolidate(folder: Path) -> None:
    """Gather the descriptions of all arrays in one place, which `xarray.open_zarr` reads at
    once.
    """
    import zarr

    with warnings_ignored():
        zarr.consolidate_metadata(folder)


def create_arrays(folder: Path, plan: Plan, pinned: Mapping[str, Any], bound: int | None) -> None:
    """All arrays of a plan, without values but those of the coordinates; `bound` is the most modes
    that a point can have.
    """
    import zarr

    names = labels([axis.name for axis in plan.space.axes])
    group = zarr.create_group(
        folder, attributes={**pinned, "coordinates": " ".join([*names, "joint_units"])}
    )
    _create_results(group, plan, bound)
    _create_coordinates(group, plan, names)
    consolidate(folder)


def _point_dimensions(plan: Plan) -> tuple[str, ...]:
    space = plan.space
    return (
        (_SAMPLE_DIMENSION,)
        if space.sample is not None
        else tuple(labels([axis.name for axis in space.axes]))
    )


def _create_results(group: Any, plan: Plan, bound: int | None) -> None:
    """The arrays that are written chunk by chunk, empty."""
    lengths = {"mode": 1} | {name: len(values) for name, values in _texts(plan).items()}
    side = max(1, min(_MODE_CHUNK, bound or _MODE_CHUNK))
    chunks = lengths | {"mode": side}
    shards = lengths | {"mode": side * -(-min(_MODE_SHARD, bound or _MODE_SHARD) // side)}
    for v in plan.variables:
        group.create_array(
            v.name,
            shape=(*plan.space.shape, *(lengths[d] for d in v.dimensions)),
            chunks=(*plan.blocks.box, *(max(1, chunks[d]) for d in v.dimensions)),
            shards=(*plan.blocks.box, *(max(1, shards[d]) for d in v.dimensions))
            if v.per_mode
            else None,
            dtype=v.dtype,
            fill_value=v.fill,
            dimension_names=(*_point_dimensions(plan), *v.dimensions),
            attributes=dict(v.attributes),
            compressors=_codecs(),
        )
    group.create_array(
        "done",
        shape=(len(plan.blocks),),
        chunks=(1,),
        dtype="uint8",
        fill_value=0,
        dimension_names=("chunk",),
        compressors=_codecs(),
        attributes={"long_name": "chunks of points that are written"},
    )


def wrongly_described(group: Any, plan: Plan) -> str | None:
    """The first array of a folder whose description is lost, or is not that of the plan: kind of
    number, shape and chunks (but along modes, which grow), what stands for nothing, how its files
    are packed. None where all are right.
    """
    import zarr

    right = zarr.create_group(zarr.storage.MemoryStore())
    _create_results(right, plan, None)
    for name in (*(v.name for v in plan.variables), "done"):
        if _description(group, name) != _description(right, name):
            return name
    for name, values in expected_coordinates(plan).items():
        told = _description(group, name)
        if (
            told is None
            or told[4] != values.shape
            or (values.dtype.kind == "f") != (told[1] == "float64")
        ):
            return name
    return None


def _description(group: Any, name: str) -> tuple[Any, ...] | None:
    """What is said of an array; None where it cannot be read."""
    try:
        array = group[name]
        names = array.metadata.dimension_names or ()
        kept = [k for k, dimension in enumerate(names) if dimension != "mode"]
        sides = (tuple(sizes[k] for k in kept) for sizes in (array.shape, array.chunks))
        packed = tuple(type(codec).__name__ for codec in array.metadata.codecs)
        return (tuple(names), str(array.dtype), repr(array.fill_value), packed, *sides)
    except Exception:
        # zarr raises whatever its parsers do
        return None


def _codecs() -> list[Any]:
    """How files are packed, with their checksums."""
    from zarr.codecs import Crc32cCodec, ZstdCodec

    return [ZstdCodec(level=_COMPRESSION_LEVEL), Crc32cCodec()]


def expected_coordinates(plan: Plan) -> dict[str, np.ndarray]:
    """What the arrays of names and coordinates hold."""
    space = plan.space
    names = labels([axis.name for axis in space.axes])
    if space.sample is None:
        values = {name: axis.values for name, axis in zip(names, space.axes, strict=True)}
    else:
        points = space.points((slice(0, space.sample),))
        values = {name: points[:, k] for k, name in enumerate(names)}
    return {
        **{name: np.array(texts, dtype=object) for name, texts in _texts(plan).items()},
        **values,
    }


def _texts(plan: Plan) -> dict[str, list[str]]:
    joints, points = (
        joint_labels(plan.problem),
        [point.name for point in plan.mechanism.link_points],
    )
    named = {"named_point": points} if points else {}
    return named | {
        "axis": ["x", "y", "z"],
        "component": ["w", "x", "y", "z"],
        "joint": [name for name, _ in joints],
        "joint_units": [unit for _, unit in joints],
    }


def _create_coordinates(group: Any, plan: Plan, names: Sequence[str]) -> None:
    """The names of what is listed, and the values of the swept joints or pose coordinates, along
    their axes or for each random point.
    """
    axes = dict(zip(names, plan.space.axes, strict=True))
    for name, values in expected_coordinates(plan).items():
        axis, own = axes.get(name), name
        told: dict[str, Any] = {"dtype": "str"}
        if axis is not None:
            said = {"units": axis.unit, "long_name": axis.name}
            told = {"dtype": "float64", "fill_value": np.nan, "attributes": said}
            own = name if plan.space.sample is None else _SAMPLE_DIMENSION
        array = group.create_array(
            name,
            shape=values.shape,
            chunks=(max(1, min(len(values), 100_000)),),
            dimension_names=("joint" if name == "joint_units" else own,),
            **told,
        )
        array[:] = values
