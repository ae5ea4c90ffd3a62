"""A trace holds each message and reception once, and agrees with what the run counted."""

from collections import defaultdict
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.erasure import Ideal
from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.channel.nr import Nr
from modelcast.channel.radio import AbstractRadio
from modelcast.channel.sidelink import Sidelink
from modelcast.core.kinds import Kind
from modelcast.runtime.fleet.engine import NetworkRun, run_network
from modelcast.runtime.fleet.loop import SERIES
from modelcast.runtime.fleet.roadside import Roadside
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.relay import RelayRule
from modelcast.station.sender import message_arrays as at
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.study.network.trace import TRACE, TraceColumns, TraceObserver
from modelcast.world.scenario.base import STEP_S, run_scenario
from modelcast.world.scenario.highway import Highway

WARM_UP_S, DURATION_S = 1.0, 6.0
TABLES = dict[str, pl.DataFrame]


def traced(
    sender: Sender, radio: AbstractRadio[object], roadside: Roadside | None = None, density: float = 60.0
) -> tuple[NetworkRun, TABLES]:
    """A run on a road of 800 m, and its trace with the number of the step beside each row."""
    parts: dict[str, list[TraceColumns]] = defaultdict(list)
    frames = run_scenario(Highway(800.0, density), np.random.default_rng(1), duration_s=DURATION_S)
    run = run_network(
        frames,
        sender,
        radio,
        NetworkSettings(warm_up_s=WARM_UP_S),
        seed=1,
        roadside=roadside,
        observer=TraceObserver(lambda name, columns: parts[name].append(columns)),
    )
    tables = {
        name: pl.concat(
            pl.DataFrame(dict(part)).with_columns(pl.lit(step).alias("step"))
            for step, part in enumerate(steps)
        )
        for name, steps in parts.items()
    }
    return run, tables


RADIOS = {"dsrc": Dsrc(), "sidelink": Sidelink(), "nr": Nr()}


@pytest.fixture(scope="module", params=RADIOS)
def crowded(request: pytest.FixtureRequest) -> tuple[NetworkRun, TABLES]:
    """So many that messages are lost; on a sidelink some expire too."""
    return traced(named_sender("bsm-10hz"), RADIOS[request.param], density=250.0)


def counted(table: pl.DataFrame) -> pl.DataFrame:
    """Rows behind the warm-up."""
    return table.filter(pl.col("step") >= round(WARM_UP_S / STEP_S))


def test_columns_are_those_described(crowded: tuple[NetworkRun, TABLES]) -> None:
    assert set(crowded[1]) == set(TRACE)
    for name, table in crowded[1].items():
        assert [one.name for one in TRACE[name]] == [one for one in table.columns if one != "step"]


def test_rows_are_what_the_run_counted(crowded: tuple[NetworkRun, TABLES]) -> None:
    run, trace = crowded
    series = dict(zip(SERIES, run.series.T, strict=True))
    steps = np.arange(len(run.series))
    for name, column in (
        ("positions", "vehicles"),
        ("transmissions", "messages"),
        ("receptions", "receptions"),
    ):
        rows = np.bincount(trace[name]["step"].to_numpy(), minlength=steps.size)
        np.testing.assert_array_equal(rows, series[column], err_msg=name)
    sent = counted(trace["transmissions"])
    assert sent.height == run.sent.causes.sum()
    assert sent["size_bytes"].sum() == run.sent.total[at.FRAME_BYTES]
    assert sent["power_dbm"].sum() == pytest.approx(run.sent.total[at.POWER_DBM])
    # Outcomes are counted by distance; on a sidelink some who leave meanwhile have none.
    assert counted(trace["receptions"]).height == pytest.approx(run.outcomes[:, 0].sum(), rel=1e-3)
    assert counted(trace["expired"]).height == run.expired


def test_no_message_is_twice_and_each_reception_is_of_one(crowded: tuple[NetworkRun, TABLES]) -> None:
    trace = crowded[1]
    key = ["origin", "message"]
    assert trace["transmissions"].select(key).is_duplicated().sum() == 0
    assert trace["receptions"].select(*key, "receiver").is_duplicated().sum() == 0
    joined = trace["receptions"].join(trace["transmissions"], on=key, how="left", suffix="_sent")
    assert joined["t_s_sent"].null_count() == 0
    assert (joined["t_s"] > joined["t_s_sent"]).all()
    assert (joined["receiver"] != joined["sender"]).all()
    assert (trace["receptions"]["sender"] == trace["receptions"]["origin"]).all()
    lost = trace["expired"].join(trace["receptions"], on=key, how="semi")
    assert lost.height == 0


def test_messages_that_expire_are_told() -> None:
    run, trace = traced(named_sender("bsm-10hz"), Sidelink(), density=250.0)
    assert 0 < run.expired == counted(trace["expired"]).height
    sent = trace["expired"].join(trace["transmissions"], on=["origin", "message"], how="semi")
    assert sent.height == trace["expired"].height


def test_distance_and_age_are_those_of_the_positions(crowded: tuple[NetworkRun, TABLES]) -> None:
    trace = crowded[1]
    places = trace["positions"].select("step", "vehicle", "east_m", "north_m")
    joined = (
        trace["receptions"]
        .join(places, left_on=["step", "sender"], right_on=["step", "vehicle"])
        .join(places, left_on=["step", "receiver"], right_on=["step", "vehicle"], suffix="_to")
    )
    assert joined.height == trace["receptions"]["distance_m"].is_not_nan().sum()
    way_m = np.hypot(joined["east_m"] - joined["east_m_to"], joined["north_m"] - joined["north_m_to"])
    np.testing.assert_allclose(joined["distance_m"], way_m)
    sent = trace["transmissions"].select("origin", "message", pl.col("t_s").alias("sent_s"))
    aged = trace["receptions"].join(sent, on=["origin", "message"])
    # A timer of 10 Hz sends within the step of its sample, and a frame takes its time on the air.
    state_s = (aged["t_s"] - aged["age_s"]).to_numpy()
    np.testing.assert_allclose(state_s, np.floor(aged["sent_s"].to_numpy() / STEP_S + 1e-9) * STEP_S)


def test_kinds_and_sub_models_are_those_that_were_sent() -> None:
    run, trace = traced(named_sender("mbc"), ErasureRadio(Ideal()))
    sent = counted(trace["transmissions"])
    assert (sent["kind"] == "identification").sum() == run.sent.total[at.IDENTIFICATIONS]
    assert set(sent["model"]) <= {member.name for member in named_sender("mbc").bank.members}
    assert sent["model"].n_unique() > 1
    assert trace["receptions"]["rssi_dbm"].is_nan().all()  # this radio knows none


def test_what_a_unit_repeats_keeps_its_origin() -> None:
    unit = Roadside(np.array([[400.0, 20.0]]), relay=RelayRule())
    run, trace = traced(named_sender("bsm-10hz"), ErasureRadio(Ideal(), 300.0), unit)
    assert run.roadside is not None
    places = trace["positions"].filter(pl.col("kind") == Kind.ROADSIDE.name.lower())
    assert places.height == len(run.series)
    assert set(zip(places["east_m"], places["north_m"], strict=True)) == {(400.0, 20.0)}
    number = places["vehicle"][0]
    sent = trace["transmissions"]
    copies = counted(sent).filter(pl.col("sender") == number)
    assert copies.height == run.roadside.repeated > 0
    assert (copies["origin"] != number).all()
    assert sent.filter(pl.col("sender") != number).filter(pl.col("sender") != pl.col("origin")).height == 0
    heard = trace["receptions"].filter(pl.col("sender") == number)
    assert heard.height > 0
    assert heard.join(copies, on=["origin", "message"], how="anti").filter(pl.col("step") > 10).height < 50


def test_the_documentation_has_all_columns() -> None:
    text = (Path(__file__).parents[2] / "docs" / "traces.md").read_text(encoding="utf-8")
    for name, columns in TRACE.items():
        rows = "".join(f"| `{one.name}` | {one.unit} | {one.description} |\n" for one in columns)
        assert f"|---|---|---|\n{rows}\n" in text.split(f"**{name}**", 1)[1], name
