"""Cooperative awareness messages in traffic, by congestion control, and as cars sent them on roads.

``cams.py FOLDER [--write | --check]`` calls ``modelcast network``, which keeps the runs that are done in the
folder, and makes the tables of `docs/cam.md`: what messages are as octets, and what traffic makes of them.
Every message is as long as one with `POINTS` points of the path behind, but for `cam-road`, which draws the
sizes of its frames.
How far stations speak in step is read from a trace of the dense call's first seed.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from pyarrow import parquet

from modelcast import BsmCore, UpdateCodec, UpdateMessage, WireProfile, bank_from_text, decode_bsm, encode_bsm
from modelcast.core.version import package_version
from modelcast.messages.cam import CamLowFrequency, CooperativeAwarenessMessage, encode_cam, path_point
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "cam.md"
CALLS = {
    "plain": ("--density 100 300 600 --lanes 10 --length 1200 --duration 14 --warm-up 8", "0 dB"),
    "dense": (
        "--density 800 --lanes 16 --length 1000 --duration 10 --warm-up 5 --radio dsrc:antenna_gain_db=3",
        "3 dB",
    ),
}
"""What is driven, and the antennas at either end."""

POLICIES = ("cam", "cam-reactive", "cam-uncontrolled", "cam-road")
POINTS, SEEDS = 23, 3
FIGURES = {
    "message_rate_hz": (1.0, ".2f"),
    "frame_bytes": (1.0, ".0f"),
    "busy_ratio": (1.0, ".3f"),
    "delivery_ratio": (1.0, ".3f"),
    "pte_p50_m": (100.0, ".1f"),
    "pte_p90_m": (100.0, ".1f"),
}
"""Factor and format of each figure."""

HEAD = (
    "| vehicles/km | antennas | policy | messages/s | bytes a frame | busy | delivered | p50 cm | p90 cm |",
    "|---|---|---|---|---|---|---|---|---|",
)


def model_octets() -> bytes:
    """The model of an update by the sub-model ``learned``, as a regional extension has it."""
    wire = WireProfile.of(bank_from_text("learned+cv"), 1)
    core = BsmCore.from_values({"message_count": 7, "temporary_id": 1, "yaw_rate_radps": 0.0})
    codes = (0,) * len(wire.layouts[0].fields)
    update = UpdateMessage(core, 0, carries_all=False, codes=(codes,))
    return decode_bsm(UpdateCodec(wire).encode(update)).regional[0][1]


def cam_octets(points: int | None, model: bytes | None = None) -> int:
    """Octets of a message with so many points of the path; None without the low-frequency container."""
    point = path_point({"delta_latitude_deg": 1e-4, "delta_longitude_deg": 0.0, "age_s": 0.5})
    low = None if points is None else CamLowFrequency(path=(point,) * points)
    values = {"station_id": 1, "generation_s": 0.0, "station_type": 5, "speed_mps": 12.3}
    return len(encode_cam(CooperativeAwarenessMessage.from_values(values, low_frequency=low, model=model)))


def bsm_octets(model: bytes | None = None) -> int:
    """Octets of a basic safety message."""
    core = BsmCore.from_values({"message_count": 7, "temporary_id": 1, "yaw_rate_radps": 0.0})
    return len(encode_bsm(core, regional=() if model is None else ((128, model),)))


def sizes() -> list[str]:
    """What messages take as octets, before anything goes round them."""
    model = model_octets()
    rows = [
        ("high-frequency container alone", cam_octets(None), cam_octets(None, model)),
        ("with the low-frequency container", cam_octets(0), cam_octets(0, model)),
        (f"with {POINTS} points of the path", cam_octets(POINTS), cam_octets(POINTS, model)),
        ("basic safety message, Part I", bsm_octets(), bsm_octets(model)),
    ]
    lines = [f"| message | octets | with a model of {len(model)} octets |", "|---|---|---|"]
    return lines + [f"| {name} | {bare} | {carrying} |" for name, bare, carrying in rows]


def drive(folder: Path, words: str, *more: str, seeds: int) -> None:
    """Call the product; runs that are done in the folder are kept."""
    longer = cam_octets(POINTS) - bsm_octets()
    call = ["network", *words.split(), "--policy", *POLICIES, "--seeds", str(seeds), "--jobs", "1", "--quiet"]
    call += ["--certificates", "digest", "--more-bytes", str(longer), "--out", str(folder), *more]
    subprocess.run([sys.executable, "-m", "modelcast", *call], check=True)  # noqa: S603 - ourselves


def driven(folder: Path, words: str) -> list[dict[str, Any]]:
    """Rows of all runs of a call; those that are done are kept."""
    drive(folder, words, seeds=SEEDS)
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))["runs"]


def rows(runs: list[dict[str, Any]], antennas: str) -> list[str]:
    """Means of all seeds, a row a density and policy."""
    lines: list[str] = []
    for density in sorted({one["density_per_km"] for one in runs}):
        for policy in POLICIES:
            own = [one for one in runs if one["density_per_km"] == density and one["policy"] == policy]
            if len(own) != SEEDS:
                raise SystemExit(f"{len(own)} runs of {policy} at {density}, not {SEEDS}")
            means = (
                f"{factor * np.mean([one[name] for one in own]):{form}}"
                for name, (factor, form) in FIGURES.items()
            )
            lines.append(f"| {density:g} | {antennas} | `{policy}` | {' | '.join(means)} |")
    return lines


def table(folder: Path) -> list[str]:
    """Rows of all calls, and what they are."""
    made = [rows(driven(folder / name, words), antennas) for name, (words, antennas) in CALLS.items()]
    said = f"Means of {SEEDS} seeds; delivered and errors are those of pairs 50 m to 150 m apart."
    return [*HEAD, *(line for one in made for line in one), "", f"{said} modelcast {package_version()}."]


def together(folder: Path) -> list[str]:
    """How unevenly the messages of the dense call fall on every other 100 ms, once it has settled."""
    folder.mkdir(parents=True, exist_ok=True)
    words, from_s = CALLS["dense"][0], 5.0
    drive(folder / "run", words, "--trace", str(folder / "trace"), seeds=1)
    lines = ["| policy | messages in the fuller half of the tenths of a second, % |", "|---|---|"]
    for policy in POLICIES:
        (path,) = (folder / "trace").glob(f"*_{policy}_*/transmissions.parquet")
        t_s = parquet.read_table(path, columns=["t_s"])["t_s"].to_numpy()
        tenth = np.floor(10.0 * t_s[t_s >= from_s]).astype(np.int64)
        odd = float(np.mean(tenth % 2))
        lines.append(f"| `{policy}` | {100.0 * max(odd, 1.0 - odd):.1f} |")
    return [*lines, "", f"800 vehicles/km as above, seed 0, from {from_s:g} s on."]


def main() -> int:
    """Run what is missing, print the tables, and write or check the page where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    asked = parser.add_mutually_exclusive_group()
    asked.add_argument("--write", action="store_true", help="put the tables into docs/cam.md")
    asked.add_argument("--check", action="store_true", help="tell whether docs/cam.md has them")
    given = parser.parse_args()
    blocks = {"cam-octets": sizes(), "cam-traffic": table(given.folder)}
    blocks["cam-together"] = together(given.folder / "together")
    print("\n".join(line for lines in blocks.values() for line in [*lines, ""]))
    return put({PAGE: blocks}, check=given.check) if given.write or given.check else 0


if __name__ == "__main__":
    sys.exit(main())
