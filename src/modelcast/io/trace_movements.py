"""Movements of a trace for other simulators: ns-2's mobility files, and BonnMotion's.

Both know nodes that are there all the time, numbered from 0. So each station of a trace is a node of its own,
in order of its number, and ``nodes.csv`` says which (`node`), of which kind, and from when to when it is
there; before and after it stands where it began and ended. Coordinates are shifted by whole metres so that
none is negative, as ns-2 wants; the shift is in the head of the file. Stations are taken some at a time, so
that memory is bounded.

ns-2 (ns-3's ``Ns2MobilityHelper`` reads it too): ``$node_(i) set X_ x`` gives the first place,
``$ns_ at t "$node_(i) setdest x y speed"`` a straight way from where it then is. BonnMotion
(``movements.gz``): a line a node, of times and places in turn, straight ways between; ``params`` beside it.
"""

import gzip
import io
from collections.abc import Iterator
from dataclasses import dataclass
from math import floor
from pathlib import Path

import numpy as np
import polars as pl

from modelcast.core.arrays import FloatArray

__all__ = ["write_bonnmotion", "write_ns2"]

_ROWS_AT_A_TIME = 1_000_000
_MARGIN_M = 1.0


@dataclass(frozen=True, slots=True)
class _Plane:
    """Where and when all nodes are: shift [m], size [m], begin and end [s]."""

    shift_m: tuple[float, float]
    size_m: tuple[float, float]
    end_s: float


def write_ns2(folder: Path) -> None:
    """Write ``positions.ns_movements`` of a trace's ``positions.parquet``.

    Parameters
    ----------
    folder
        The trace.
    """
    plane, nodes = _nodes(folder)
    with (folder / "positions.ns_movements").open("w", encoding="utf-8", newline="\n") as out:
        _write_head(out, plane, len(nodes))
        for node, t_s, place_m in _ways(folder, plane, nodes):
            out.write(f"$node_({node}) set X_ {place_m[0, 0]:.4f}\n")
            out.write(f"$node_({node}) set Y_ {place_m[0, 1]:.4f}\n")
            out.write(f"$node_({node}) set Z_ 0.0\n")
            way_m = np.hypot(*np.diff(place_m, axis=0).T)
            for k in np.flatnonzero(way_m > 0.0):
                east_m, north_m = place_m[k + 1]
                speed_mps = way_m[k] / (t_s[k + 1] - t_s[k])
                out.write(
                    f'$ns_ at {t_s[k]:.6f} "$node_({node}) setdest {east_m:.4f} {north_m:.4f} '
                    f'{speed_mps:.9g}"\n'
                )


def _write_head(out: io.TextIOBase, plane: _Plane, nodes: int) -> None:
    out.write(f"# nodes: {nodes}, max x: {plane.size_m[0]:.1f}, max y: {plane.size_m[1]:.1f}\n")
    out.write(f"# end: {plane.end_s:.6f} s; shifted by {plane.shift_m[0]:g} m, {plane.shift_m[1]:g} m\n")
    out.write("# who is which node, and from when to when: nodes.csv\n")


def write_bonnmotion(folder: Path) -> None:
    """Write ``positions.movements.gz`` and ``positions.params`` of a trace's ``positions.parquet``.

    Parameters
    ----------
    folder
        The trace.
    """
    plane, nodes = _nodes(folder)
    # No name and no time inside: the same run gives the same bytes.
    with (
        (folder / "positions.movements.gz").open("wb") as file,
        gzip.GzipFile("", "wb", fileobj=file, mtime=0) as packed,
    ):
        for _, t_s, place_m in _ways(folder, plane, nodes):
            line = " ".join(
                f"{t:.6f} {east:.4f} {north:.4f}"
                for t, (east, north) in zip(t_s.tolist(), place_m.tolist(), strict=True)
            )
            packed.write(f"{line}\n".encode("ascii"))
    values = {
        "model": "modelcast",
        "ignore": "0.0",
        "randomSeed": "0",
        "x": f"{plane.size_m[0]:.1f}",
        "y": f"{plane.size_m[1]:.1f}",
        "duration": f"{plane.end_s:.6f}",
        "nn": str(len(nodes)),
        "circular": "false",
    }
    text = "".join(f"{name}={value}\n" for name, value in values.items())
    (folder / "positions.params").write_text(text, encoding="ascii")


def _nodes(folder: Path) -> tuple[_Plane, pl.DataFrame]:
    """Return the plane and a row a node, and write ``nodes.csv``."""
    positions = pl.scan_parquet(folder / "positions.parquet")
    nodes = (
        positions.group_by("vehicle")
        .agg(
            pl.col("kind").first(),
            pl.col("t_s").min().alias("from_s"),
            pl.col("t_s").max().alias("to_s"),
            pl.len().alias("rows"),
        )
        .sort("vehicle")
        .with_row_index("node")
        .collect()
    )
    columns = ("east_m", "north_m")
    found = positions.select(
        *(pl.col(name).min().alias(f"low_{name}") for name in columns),
        *(pl.col(name).max().alias(f"high_{name}") for name in columns),
        pl.col("t_s").max(),
    ).collect()
    low, high = ([float(found[f"{end}_{name}"][0] or 0.0) for name in columns] for end in ("low", "high"))
    shift_m = tuple(float(max(0, -floor(value - _MARGIN_M))) for value in low)
    size_m = tuple(float(floor(a + b + 2.0 * _MARGIN_M)) for a, b in zip(high, shift_m, strict=True))
    nodes.drop("rows").write_csv(folder / "nodes.csv")
    end_s = float(found["t_s"][0] or 0.0)
    return _Plane((shift_m[0], shift_m[1]), (size_m[0], size_m[1]), end_s), nodes


def _ways(folder: Path, plane: _Plane, nodes: pl.DataFrame) -> Iterator[tuple[int, FloatArray, FloatArray]]:
    """Yield node by node its number, times (T,) [s] and shifted places (T, 2) [m]."""
    positions = pl.scan_parquet(folder / "positions.parquet")
    batch = (nodes["rows"].cum_sum() // _ROWS_AT_A_TIME).alias("batch")
    for part in nodes.with_columns(batch).partition_by("batch", maintain_order=True):
        held = (
            positions.filter(pl.col("vehicle").is_in(part["vehicle"].to_list()))
            .select("vehicle", "t_s", "east_m", "north_m")
            .collect()
            .sort("vehicle", "t_s")
        )
        first = 0
        for node, rows in part.select("node", "rows").iter_rows():
            own = held.slice(first, rows)
            first += rows
            place_m = own.select("east_m", "north_m").to_numpy() + np.array(plane.shift_m)
            yield node, own["t_s"].to_numpy(), place_m
