"""Claims about tables of results on disk: all outputs hold the same values, and say what they are."""

import io
import json
import math
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import ConfigError, DataFormatError
from modelcast.io.ranking import RANKING
from modelcast.io.table_files import (
    read_table,
    read_table_schema,
    schema_document,
    table_document,
    write_table,
)
from modelcast.report.tables import frame
from modelcast.study.compare.result import COUNTS, TRACKING_RATIOS
from modelcast.study.coverage import COVERAGE
from modelcast.study.cruise.run import CRUISE
from modelcast.study.network.rows import CASE_TABLES, RUNS
from modelcast.study.network.warning_rows import POOLED_WARNINGS
from modelcast.study.result import RATES, TRACKING
from modelcast.study.safety.result import EVENTS, POOLED_SAFETY
from modelcast.study.table import Column, Table, TableSchema, count, flag, quantity, ratio, text

SCHEMA = TableSchema(
    "made",
    "Anything.",
    (
        text("name", "A name, of an ä."),
        text("bank", "A bank.", missing="none was given"),
        count("frames", "Frames."),
        flag("stable", "Whether."),
        ratio("busy_ratio", "Busy."),
        quantity("age_s", "s", "Age.", missing="nothing was heard"),
        quantity("power_dbm", "dBm", "Power."),
    ),
)
WORDS = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), min_size=1, max_size=5)
NUMBERS = st.floats(allow_nan=True, allow_infinity=False)
VALUES = {"text": WORDS, "count": st.integers(0, 2**53), "flag": st.booleans(), "ratio": st.floats(0.0, 1.0)}


def values(column: Column) -> st.SearchStrategy[Any]:
    found = VALUES.get(column.kind, NUMBERS)
    return st.none() | found if column.missing else found


ROWS = st.lists(st.fixed_dictionaries({column.name: values(column) for column in SCHEMA.columns}), max_size=6)


def same(one: Any, other: Any) -> bool:
    """Equal, where a number that does not exist is like none."""
    absent = [value is None or (isinstance(value, float) and math.isnan(value)) for value in (one, other)]
    return all(absent) or (one == other and not any(absent))


def agree(rows: list[dict[str, Any]], table: Table) -> bool:
    wanted = [dict(row.items()) for row in table]
    return len(rows) == len(wanted) and all(
        row.keys() == own.keys() and all(same(row[name], own[name]) for name in own)
        for row, own in zip(rows, wanted, strict=True)
    )


@given(ROWS)
def test_frame_parquet_json_and_csv_hold_the_same(rows: list[dict[str, Any]]) -> None:
    table = SCHEMA.table(SCHEMA.row(**row) for row in rows)
    assert agree(frame(table).to_dicts(), table)
    files = {form: io.BytesIO() for form in ("parquet", "json", "csv")}
    for form, file in files.items():
        write_table(table, file, form)
    assert agree(pl.read_parquet(files["parquet"].getvalue()).to_dicts(), table)
    assert agree(json.loads(files["json"].getvalue())["rows"], table)
    assert json.loads(files["json"].getvalue()) == table_document(table)
    types = dict(frame(table).schema)
    read = pl.read_csv(
        files["csv"].getvalue(),
        schema={name: pl.String if kind == pl.Boolean else kind for name, kind in types.items()},
    )
    found = [{**row, "stable": row["stable"] == "True"} for row in read.to_dicts()]
    assert agree(found, table)


@given(ROWS)
def test_a_table_comes_back_from_parquet(rows: list[dict[str, Any]]) -> None:
    table = SCHEMA.table(SCHEMA.row(**row) for row in rows)
    file = io.BytesIO()
    write_table(table, file)
    found = read_table(SCHEMA, io.BytesIO(file.getvalue()), remedy="none")
    assert agree([dict(row.items()) for row in found], table)


def test_the_same_table_gives_the_same_bytes(tmp_path: Path) -> None:
    row = {"name": "a", "bank": None, "frames": 1, "stable": True, "busy_ratio": 0.1, "age_s": 1.0}
    table = SCHEMA.table([SCHEMA.row(**row, power_dbm=20.0)])
    for form in ("parquet", "json", "csv"):
        for at in ("one", "two"):
            write_table(table, tmp_path / at, form)
        assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_a_file_says_unit_and_meaning_of_every_column(tmp_path: Path) -> None:
    write_table(RUNS.table(), tmp_path / "runs.parquet")
    found = read_table_schema(tmp_path / "runs.parquet")
    assert found == schema_document(RUNS)
    (error,) = [one for one in found["columns"] if one["name"] == "pte_p90_m"]
    assert (error["unit"], error["kind"]) == ("m", "number")
    assert error["description"] == "Tracking error: percentile 90."
    pl.DataFrame({"a": [1]}).write_parquet(tmp_path / "bare.parquet")
    with pytest.raises(ConfigError, match=r"bare\.parquet says nothing of its columns"):
        read_table_schema(tmp_path / "bare.parquet")


def test_what_is_no_such_table_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "traffic.parquet"
    path.write_bytes(b"PAR1 and nothing more")
    with pytest.raises(DataFormatError, match="is no table of 'made'"):
        read_table(SCHEMA, path, remedy="Name another.")
    pl.DataFrame({"name": ["a"]}).write_parquet(path)
    with pytest.raises(DataFormatError, match="is no table of 'made'"):
        read_table(SCHEMA, path, remedy="Name another.")
    pl.DataFrame({column.name: ["x"] for column in SCHEMA.columns}).write_parquet(path)
    with pytest.raises(DataFormatError, match=r"made\.frames is a count"):
        read_table(SCHEMA, path, remedy="Name another.")


CASE = "density_per_km radio policy bank threshold_m run"
HELD = "held_ratio pte_p50_m pte_p90_m pte_p95_m pte_p99_m"
TIMES = "age_p50_s age_p90_s gap_p50_s gap_p90_s"
SPAN = "low_m high_m"
WARNED = f"{CASE} application sender reading"
GOLDEN = {
    "rates": (
        RATES,
        (
            "trip policy bank threshold_m updates identifications duration_s update_rate_hz "
            "identification_rate_hz total_rate_hz moving_total_rate_hz bytes_per_s airtime_per_s"
        ),
    ),
    "tracking": (
        TRACKING,
        (
            "trip policy bank rate_basis threshold_m own_threshold_m packet_error_ratio seeds samples "
            "excluded_samples message_rate_hz pte_mean_m pte_p50_m pte_p90_m pte_p90_low_m pte_p90_high_m "
            "pte_p95_m pte_p99_m pte_before_p90_m along_p90_m cross_p90_m beyond_lane_ratio "
            "inter_packet_gap_p50_s inter_packet_gap_p95_s information_age_mean_s information_age_p95_s"
        ),
    ),
    "messages.parquet of compare": (
        COUNTS,
        (
            "candidate protocol trip route threshold_m updates identifications message_bytes "
            "baseline_messages "
            "baseline_bytes airtime_s baseline_airtime_s duration_s"
        ),
    ),
    "tracking.parquet of compare": (
        TRACKING_RATIOS,
        (
            "candidate protocol trip threshold_m packet_error_ratio rate_basis message_rate_hz "
            "matched_rate_hz periodic_rate_hz baseline_rate_hz free_rate_hz free_matched_rate_hz "
            "p90_m matched_p90_m periodic_p90_m p90_ratio p90_low p90_high baseline_p90_m "
            "free_p90_m free_matched_p90_m p90_over_free p90_over_free_low p90_over_free_high "
            "p99_m matched_p99_m periodic_p99_m p99_ratio p99_low p99_high baseline_p99_m "
            "free_p99_m free_matched_p99_m p99_over_free p99_over_free_low p99_over_free_high"
        ),
    ),
    "coverage": (COVERAGE, "sub_model form horizon_s level covered_ratio errors"),
    "runs.parquet of cruise": (
        CRUISE,
        (
            "sender threshold_m loss_ratio burst_s rate_hz bytes_per_s airtime_per_s fewer_messages_ratio "
            "speed_change_ratio speed_amplification spacing_amplification stable_ratio spacing_peak_m "
            "spacing_rms_m gap_min_m collisions followers acceleration_rms_mps2 jerk_rms_mps3 "
            "fell_back_ratio "
            "age_s"
        ),
    ),
    "runs.parquet of network": (
        RUNS,
        (
            f"{CASE} vehicles message_rate_hz update_rate_hz identification_rate_hz time_ratio "
            "dynamics_ratio "
            "critical_ratio model_ratio certificate_ratio payload_bytes frame_bytes bytes_per_s "
            "airtime_ratio "
            "power_dbm busy_ratio expired_ratio delivery_ratio collision_ratio hidden_ratio concurrent_ratio "
            f"half_duplex_ratio weak_ratio {HELD} relative_p50_m relative_p90_m relative_p99_m {TIMES} "
            "gap_p99_s "
            "neighbours inter_transmit_time_s channel_quality tracks_per_s"
        ),
    ),
    "distances": (CASE_TABLES["distances"], f"{CASE} {SPAN} pairs {HELD} {TIMES}"),
    "outcomes": (
        CASE_TABLES["outcomes"],
        f"{CASE} {SPAN} pairs received_ratio half_duplex_ratio weak_ratio hidden_ratio concurrent_ratio",
    ),
    "seconds": (
        CASE_TABLES["seconds"],
        (
            f"{CASE} t_s message_rate_hz busy_ratio power_dbm neighbours inter_transmit_time_s "
            "channel_quality "
            "pte_p90_m"
        ),
    ),
    "pairings": (
        CASE_TABLES["pairings"],
        (
            f"{CASE} senders_ratio sender reading message_rate_hz bytes_per_s airtime_ratio held_ratio "
            "pte_p50_m "
            "pte_p90_m pte_p99_m age_p50_s age_p90_s pairs"
        ),
    ),
    "penetration": (
        CASE_TABLES["penetration"],
        f"{CASE} senders_ratio receivers_ratio pte_p50_m pte_p90_m pte_p99_m",
    ),
    "warnings": (
        CASE_TABLES["warnings"],
        f"{WARNED} host_s counted events never positives missed negatives false false_warnings",
    ),
    "warned_hosts": (CASE_TABLES["warned_hosts"], f"{WARNED} host negatives false false_warnings"),
    "warned_events": (
        CASE_TABLES["warned_events"],
        f"{WARNED} host remote t_s positives missed delay_s",
    ),
    "pooled_warnings": (
        POOLED_WARNINGS,
        (
            "density_per_km radio policy bank threshold_m application sender reading seeds message_rate_hz "
            "busy_ratio events positives negatives missed_ratio missed_low missed_high false_ratio false_low "
            "false_high false_per_hour never_ratio delay_p50_s delay_p90_s delay_p99_s missed_over "
            "missed_over_low missed_over_high false_over false_over_low false_over_high"
        ),
    ),
    "roadside": (
        CASE_TABLES["roadside"],
        (
            f"{CASE} units busy_ratio delivery_ratio repeated_rate_hz repeated_bytes_per_s unsent_ratio "
            f"by_another_rate_hz replaced_rate_hz too_old_rate_hz too_far_rate_hz {HELD} {TIMES}"
        ),
    ),
    "roadside_distances": (
        CASE_TABLES["roadside_distances"],
        f"{CASE} {SPAN} frames pairs delivery_ratio {HELD} {TIMES}",
    ),
    "people": (
        CASE_TABLES["people"],
        (
            f"{CASE} people_policy people message_rate_hz certificate_ratio frame_bytes airtime_ratio "
            "power_dbm "
            "received_rate_hz unread_rate_hz far_rate_hz read_rate_hz"
        ),
    ),
    "pooled.parquet of safety": (
        POOLED_SAFETY,
        (
            "sensor mean_burst_s packet_error_ratio basis candidate threshold_m message_rate_hz "
            "airtime_ratio "
            "missed_ratio false_ratio missed_events false_per_hour delay_p50_s delay_p90_s delay_p99_s "
            "missed_over false_over missed_over_low missed_over_high false_over_low false_over_high loss_log"
        ),
    ),
    "events.parquet of safety": (
        EVENTS,
        (
            "recording sensor mean_burst_s loss_log packet_error_ratio basis candidate leader follower run "
            "t_s "
            "instants missed delay_s"
        ),
    ),
    "ranking": (
        RANKING,
        (
            "rank trip manoeuvres kinds per_km duration_s distance_m lane_changes turns u_turns roundabouts "
            "stops hard_brakes"
        ),
    ),
}


@pytest.mark.parametrize("name", GOLDEN)
def test_result_files_keep_their_columns_in_order(name: str) -> None:
    schema, names = GOLDEN[name]
    assert schema.names == tuple(names.split())
