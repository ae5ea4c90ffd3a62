"""Claims about the paragraphs that a report begins with."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from modelcast.models.profile import default_profile
from modelcast.report.captions import captions
from modelcast.report.findings import findings
from modelcast.report.html import report_document
from modelcast.station.banks import bank_from_text
from modelcast.study.result import RATES, TRACKING, EvaluationResult
from modelcast.study.settings import EvaluationSettings
from modelcast.study.table import Row

Make = Callable[..., EvaluationResult]


def told(result: EvaluationResult) -> list[str]:
    """What was found, what was not, the data, the words."""
    found = findings(result)
    assert [title for title, _ in found] == ["Found", "Not found", "Data", "Words"][: len(found)]
    return [text for _, text in found]


def with_rates(result: EvaluationResult, mbc: float, free: float = 1.0) -> EvaluationResult:
    """The same with so many messages over the baseline's."""
    hz = {"mbc": mbc, "free": free, "baseline": 1.0}
    return replace(
        result, rates=RATES.table(row.replaced(total_rate_hz=hz[row.policy]) for row in result.rates)
    )


def with_errors(
    result: EvaluationResult, half_width: float | None = 0.001, **p90_m: float
) -> EvaluationResult:
    """The same with errors of 1 m but for those given, and intervals of this half width."""

    def made(row: Row) -> Row:
        value = p90_m.get(row.policy.replace("-", "_"), 1.0)
        ends = (None, None) if half_width is None else (value - half_width, value + half_width)
        return row.replaced(pte_p90_m=value, pte_p90_low_m=ends[0], pte_p90_high_m=ends[1])

    return replace(result, tracking=TRACKING.table(made(row) for row in result.tracking))


def without(result: EvaluationResult, *policies: str) -> EvaluationResult:
    return replace(
        result,
        rates=RATES.table(row for row in result.rates if row.policy not in policies),
        tracking=TRACKING.table(row for row in result.tracking if row.policy not in policies),
    )


@pytest.mark.parametrize(
    ("mbc", "said"),
    [
        (
            0.5,
            "sent fewer messages than the baseline (0.50 times as many)",
        ),
        (
            1.0,
            "sent as many messages as the baseline (1.00 times as many)",
        ),
        (0.97, "sent about as many messages as the baseline (0.97 times as many)"),
        (1.03, "sent about as many messages as the baseline (1.03 times as many)"),
        (0.96, "sent fewer messages than the baseline (0.96 times as many)"),
        (
            1.2,
            "sent more messages than the baseline (1.20 times as many)",
        ),
    ],
)
def test_the_verb_of_messages_is_that_of_their_ratio(make_result: Make, mbc: float, said: str) -> None:
    assert said in told(with_rates(make_result(), mbc))[0]


def test_thresholds_that_differ_are_told_as_a_range(make_result: Make) -> None:
    result = make_result(thresholds=(0.2, 0.5))
    rates = RATES.table(
        row.replaced(total_rate_hz=(2.5 if row.threshold_m == 0.2 else 0.5) if row.policy == "mbc" else 1.0)
        for row in result.rates
    )
    said = told(replace(result, rates=rates))[0]
    assert "sent fewer or more messages than the baseline" in said
    assert "0.50 to 2.50 times as many" in said


def test_mbc_is_told_at_its_first_use(make_result: Make) -> None:
    first, _, _, words = told(make_result())
    assert first.count("MBC") == 1
    assert "MBC (model-based communication) sent" in first
    assert words.startswith("MBC: a vehicle sends a small model of its motion")
    assert "free receiver: plain messages" in words
    foreign = replace(make_result(), settings={"decided_by": "soon"})
    renamed = {"rates": RATES, "tracking": TRACKING}
    tables = {
        name: schema.table(
            row.replaced(policy="soon") if row.policy == "mbc" else row for row in getattr(foreign, name)
        )
        for name, schema in renamed.items()
    }
    other = told(replace(foreign, **tables))
    assert "At the same threshold, without loss, soon sent" in other[0]
    assert other[3].startswith(
        "soon: a vehicle sends a small model of its motion, when the policy soon calls"
    )


@pytest.mark.parametrize(
    ("mbc", "said"),
    [
        (0.5, "was smaller than the better baseline's (0.62 times as large)"),
        (0.8, "was as large as the better baseline's (1.00 times as large)"),
        (1.6, "was larger than the better baseline's (2.00 times as large)"),
    ],
)
def test_errors_at_equal_rate_are_held_against_the_harder_baseline(
    make_result: Make, mbc: float, said: str
) -> None:
    first = told(with_errors(make_result(), mbc=mbc, baseline_matched=0.8))[0]
    assert "At the same rate, with 40 % of the messages lost, its error (90th percentile)" in first
    assert said in first


def test_cells_in_which_mbc_is_worse_are_counted_by_reading_and_the_worst_is_named(make_result: Make) -> None:
    """At the same threshold with what it saved: fewer messages and a larger error belong together."""
    result = with_errors(make_result(), mbc=2.57, baseline=1.58, free=3.0, free_matched=3.0)
    worst = next(row for row in result.tracking if row.policy == "mbc" and row.trip == "all")
    halved = TRACKING.table(
        row.replaced(message_rate_hz=0.5 * worst.message_rate_hz) if row.policy == "mbc" else row
        for row in result.tracking
    )
    second = told(replace(result, tracking=halved))[1]
    assert (
        "the baseline's in all 12 at the same threshold (most at 20 cm, 20 % lost: 2.57 against 1.58 m, "
        "for 0.50 times the messages) and in all 12 at the same rate (most at" in second
    )
    assert (
        "the free receiver's in none of 12 at the same threshold and in none of 12 at the same rate" in second
    )


@pytest.mark.parametrize(
    ("half_width", "said"),
    [
        (0.001, "its interval over the seeds and the free receiver's overlap in none of 12."),
        (2.0, "its interval over the seeds and the free receiver's overlap in all 12."),
        (None, "One seed has no interval that tells this from chance."),
    ],
)
def test_what_may_be_chance_is_told(make_result: Make, half_width: float | None, said: str) -> None:
    assert said in told(with_errors(make_result(), half_width, mbc=0.5))[1]


def test_a_run_without_loss_says_nothing_of_losses(make_result: Make) -> None:
    first, second, _, _ = told(make_result(ratios=(0.0,)))
    assert "At the same rate, without loss, its error" in first
    assert "in none of 4 at the same threshold" in second
    assert "No message was lost, so nothing is said of losses." in second
    assert "was lost" not in told(make_result())[1]


def test_a_run_of_rates_alone_says_that_no_error_was_measured(make_result: Make) -> None:
    first, second, _, _ = told(replace(make_result(), tracking=TRACKING.table()))
    assert "error (90th" not in first
    assert second.startswith("Errors were not measured")


@pytest.mark.parametrize(
    ("mbc", "free", "said"),
    [
        (0.5, 0.55, "Without loss the free receiver saves 0.45 of the baseline's messages, MBC 0.50. Under"),
        (0.5, 1.2, "free receiver saves -0.20 of the baseline's messages, MBC 0.50. Below 0 it sends more."),
        (1.004, 0.4, "the free receiver saves 0.60 of the baseline's messages, MBC 0.00. Under"),
    ],
)
def test_where_the_saving_comes_from_is_told(make_result: Make, mbc: float, free: float, said: str) -> None:
    result = with_settings(with_rates(make_result(), mbc, free), believe="expected")
    assert said in told(result)[1]


def test_savings_are_told_of_every_threshold_also_where_models_save_nothing(make_result: Make) -> None:
    result = make_result(thresholds=(0.2, 0.5))
    hz = {("mbc", 0.2): 1.3, ("mbc", 0.5): 0.9, ("free", 0.2): 0.7, ("free", 0.5): 0.8}
    rates = (row.replaced(total_rate_hz=hz.get((row.policy, row.threshold_m), 1.0)) for row in result.rates)
    said = told(replace(result, rates=RATES.table(rates)))[1]
    assert "the free receiver saves 0.20 to 0.30 of the baseline's messages, MBC -0.30 to 0.10." in said


def test_nothing_is_said_of_who_was_not_run(make_result: Make) -> None:
    said = " ".join(told(without(with_rates(make_result(), 0.5), "free", "free-matched")))
    assert "free receiver" not in said
    alone = told(
        without(make_result(), "free", "free-matched", "baseline", "baseline-matched", "baseline-periodic")
    )
    assert "was run alone" in alone[0]
    assert alone[1] == "Nobody's errors were measured beside MBC's."


def test_the_data_are_told_with_number_time_origin_and_sensors(make_result: Make) -> None:
    result = make_result()
    sensor = {"position_noise_m": 0.01, "slow_position_noise_m": 0.0, "heading_noise_rad": 0.0174533}
    seen = replace(result, settings={**result.settings, "sensor": sensor})
    third = told(seen)[2]
    assert third.startswith("3 trips, 30.1 min, read from csv; protocol recorded (2 of them)")
    assert (
        "the truth (smoothed) through sensors with standard errors of 0.01 m in position and 1° in heading"
        in third
    )
    assert "One trip" not in third


def test_one_generated_trip_is_told_as_such(make_result: Make) -> None:
    result = make_result(trips=("generated/0",))
    made = replace(result, trips=tuple(replace(trip, source="generated") for trip in result.trips))
    third = told(made)[2]
    assert "1 trip, 10.0 min, generated by a program, not recorded" in third
    assert third.endswith(". One trip says nothing of others.")
    mixed = make_result()
    first, *others = mixed.trips
    both = replace(mixed, trips=(replace(first, source="generated"), *others))
    assert "1 generated by a program, not recorded and 2 read from csv" in told(both)[2]


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("sumo-fcd", "30.1 min, simulated by SUMO, not recorded; "),
        ("parquet", "30.1 min, read from parquet; "),
        ("highd", "30.1 min, recorded (highd); "),
    ],
)
def test_where_trips_come_from_is_told_by_what_their_format_knows(
    make_result: Make, source: str, said: str
) -> None:
    result = make_result()
    assert (
        said in told(replace(result, trips=tuple(replace(trip, source=source) for trip in result.trips)))[2]
    )


def with_loss_rates(result: EvaluationResult, **hz: tuple[float, float]) -> EvaluationResult:
    """The same with so many messages in the loss runs: without loss and with; 1 a second of the others."""

    def made(row: Row) -> Row:
        without_hz, with_hz = hz.get(row.policy, (1.0, 1.0))
        return row.replaced(message_rate_hz=with_hz if row.packet_error_ratio else without_hz)

    return replace(result, tracking=TRACKING.table(made(row) for row in result.tracking))


def with_settings(result: EvaluationResult, **settings: object) -> EvaluationResult:
    return replace(result, settings={**result.settings, **settings})


def test_messages_without_loss_do_not_stand_for_those_with(make_result: Make) -> None:
    result = with_loss_rates(with_rates(make_result(), 0.5), mbc=(0.6, 0.84), free=(0.7, 0.7))
    first = told(result)[0]
    assert "At the same threshold, without loss, MBC (model-based communication) sent fewer messages" in first
    assert "(0.50 times as many)" in first
    assert (
        "With 40 % of the messages lost and a message at least every 2 s, it sent fewer messages than the "
        "baseline (0.84 times as many) and more messages than the free receiver (1.20 times as many)."
        in first
    )
    silent = told(with_settings(result, keep_alive_s=None))[0]
    assert "With 40 % of the messages lost, it sent fewer messages" in silent


def test_a_run_without_loss_tells_what_keeping_alive_costs(make_result: Make) -> None:
    result = with_loss_rates(make_result(ratios=(0.0,)), mbc=(0.6, 0.6))
    assert (
        "With a message at least every 2 s, it sent fewer messages than the baseline (0.60" in told(result)[0]
    )
    assert "it sent" not in told(with_settings(result, keep_alive_s=None))[0]


def test_who_repeats_under_loss_is_told_and_that_the_baseline_does_not(make_result: Make) -> None:
    result = with_loss_rates(make_result(), mbc=(0.6, 0.9), free=(0.5, 0.85))
    second = told(with_settings(result, believe="expected"))[1]
    assert (
        "Under losses MBC and the free receiver's sender also repeat: they know the share lost and send up "
        "to 1.7 times as much. The baseline does not repeat." in second
    )
    alone = told(with_settings(without(result, "free", "free-matched"), believe="expected"))[1]
    assert "Under losses MBC also repeats: it knows the share lost and sends up to 1.5 times as much" in alone
    assert "repeat" not in " ".join(told(with_settings(result, believe="sent")))
    lossless = with_settings(make_result(ratios=(0.0,)), believe="expected")
    assert "repeat" not in " ".join(told(lossless))


def test_a_bank_of_plain_messages_is_not_told_as_one_of_models(make_result: Make) -> None:
    plain = {"plain_messages": True, "sub_model_names": ["cv"], "is_free_receiver": False}
    words = told(with_settings(make_result(), **plain))[3]
    assert words.startswith(
        "MBC: this bank sends no model; plain messages, coasted at constant velocity, and"
    )
    assert "small model" not in words


def test_the_free_receiver_evaluated_is_told_as_itself(make_result: Make) -> None:
    itself = {"plain_messages": True, "sub_model_names": ["free"], "is_free_receiver": True}
    result = with_settings(without(make_result(), "free", "free-matched"), **itself)
    first, _, _, words = told(result)
    assert "Its bank is the free receiver's, so none is run beside it." in first
    assert "coasted with their acceleration and turn as well" in words
    assert "this is the free receiver itself" in words
    assert "MBC is the free receiver itself here" in captions(result)["message_rate"]


def test_the_free_receiver_is_told_by_what_it_coasts_with(make_result: Make) -> None:
    people = with_settings(make_result(), free_names=["stop-and-go"])
    for text in (told(people)[3], *(captions(people)[name] for name in ("message_rate", "tracking_loss"))):
        assert "free receiver: plain messages, coasted by the stop-and-go switch" in text
        assert "acceleration and turn" not in text
    assert "acceleration and turn" in captions(make_result())["tracking_loss"]
    unopposed = captions(without(make_result(), "free", "free-matched"))["tracking_loss"]
    assert "free receiver" not in unopposed


@pytest.mark.parametrize(
    ("text", "plain", "itself"), [("cv", True, False), ("free", True, True), ("default", False, False)]
)
def test_settings_say_what_a_bank_sends(text: str, plain: bool, itself: bool) -> None:
    bank = default_profile().bank if text == "default" else bank_from_text(text)
    told = EvaluationSettings(bank=bank).as_plain()
    assert (told["plain_messages"], told["is_free_receiver"]) == (plain, itself)
    assert told["sub_model_names"] == [member.name for member in bank.members]
    assert told["free_names"] == (None if itself else ["free"])


def test_a_result_of_nothing_has_no_sentence(make_result: Make) -> None:
    assert findings(replace(make_result(), trips=())) == []


def test_long_lists_of_columns_are_cut_at_a_word(make_result: Make) -> None:
    result = make_result(trips=("a/1",))
    way = {"columns": "t=Time", "not used": "speed of wheel " * 20}
    (trip,) = result.trips
    said = told(replace(result, trips=(replace(trip, understood=way),)))[2]
    assert "not used: speed of wheel speed" in said
    assert "speed of wheel and more." in said
    assert len(said.partition("not used: ")[2].partition(".")[0]) <= 160


def test_the_data_says_what_columns_were_taken_for_and_of_several_ways_where_they_stand(
    make_result: Make, read_page: Callable[[str], Any]
) -> None:
    result = make_result(trips=("a/1", "b/2"))
    one = {"columns": "t=Time, lat=Breite", "assumed": "Breite in degrees", "not used": "rpm"}
    other = {**one, "columns": "t=Time, lat=Lat"}
    assert "Columns taken" not in told(result)[2]
    alike = replace(result, trips=tuple(replace(trip, understood=one) for trip in result.trips))
    said = told(alike)[2]
    assert "Columns taken: t=Time, lat=Breite; only assumed: Breite in degrees; not used: rpm." in said
    part = told(replace(result, trips=(alike.trips[0], result.trips[1])))[2]
    assert " Of 1 of 2 trips: columns taken: t=Time, lat=Breite; only assumed" in part
    pairs = zip(result.trips, (one, other), strict=True)
    apart = replace(result, trips=tuple(replace(trip, understood=way) for trip, way in pairs))
    assert "Their files were understood in 2 ways, which report.html lists above the trips." in told(apart)[2]
    words = " ".join(read_page(report_document(apart, ())).text.split())
    assert "b/2: columns t=Time, lat=Lat; assumed Breite in degrees; not used rpm." in words
