"""Claims: the page plays every message and every peak, and runs nothing but its own scripts."""

import base64
import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from modelcast.report.html import report_document
from modelcast.report.playback import (
    MOST_SAMPLES,
    PATH_WITHIN_M,
    playback_caption,
    playback_document,
    played_samples,
)
from modelcast.report.player import player
from modelcast.report.scripts import static_text
from modelcast.station.policy.base import MessageKind
from modelcast.study.playback import Playback, PlayedRun
from modelcast.study.result import EvaluationResult

Make = Callable[..., EvaluationResult]

UPLOT_SHA256 = {
    "uPlot.iife.min.js": "19c8d4c6ad88929a79f4ae49d6f7161566dfd0ba3d15cc495e974f787eb78f1f",
    "uPlot.min.css": "df630c6a8d6f8eeaff264b50f73ce5b114f646ffd9a0bb74f049b0a00135fa04",
    "uPlot.LICENSE": "8f989229699b4fe2f1a0432d0e9edc338a8a911e250e2d1b01ecd770a5f5b1bd",
}
"""Of the files of uPlot 1.6.32 as npm has them."""


def _made(samples: int, *, trip: str = "made/1") -> Playback:
    """A trip with a gap, two senders, and errors with a peak that lasts one sample."""
    rng = np.random.default_rng(5)
    t_s = 0.1 * np.arange(samples, dtype=np.float64)
    t_s[samples // 2 :] += 7.0
    truth_m = np.stack([9.0 * t_s + 310.0, 40.0 * np.sin(t_s / 30.0)], axis=1)

    def run(sender: str, members: tuple[str, ...]) -> PlayedRun:
        off_m = rng.normal(0.0, 0.05, (samples, 2))
        off_m[samples // 5] = [3.0, 4.0]
        off_m[:3] = np.nan
        sent = np.flatnonzero(rng.random(samples) < 0.15)
        return PlayedRun(
            sender,
            members,
            packet_error_ratio=0.4,
            believed_m=truth_m + off_m,
            sent=sent,
            kind=rng.choice([kind.value for kind in MessageKind if kind], sent.size),
            in_use=rng.integers(0, len(members), sent.size),
            lost=rng.random(sent.size) < 0.4,
        )

    return Playback(
        trip,
        0.3,
        at_s=float(t_s[samples // 3]),
        t_s=t_s,
        truth_m=truth_m,
        parts=np.array([samples // 2]),
        runs=(run("mbc", ("ctra", "cv")), run("baseline", ("cv",))),
    )


def _sums(steps: list[int | None], unit: float) -> np.ndarray:
    """Numbers from differences, as the page's script reads them."""
    known = list(accumulate(step for step in steps if step is not None))
    after = iter(known)
    return np.array([np.nan if step is None else unit * next(after) for step in steps])


@pytest.mark.parametrize("samples", [500, 20_000])
def test_what_the_page_gets_reads_back(make_result: Make, samples: int) -> None:
    playback = _made(samples)
    found: Any = json.loads(json.dumps(playback_document(replace(make_result(), playback=playback))))
    kept = played_samples(playback)
    np.testing.assert_allclose(_sums(found["t_ms"], 1e-3), playback.t_s[kept], atol=0.51e-3)
    np.testing.assert_allclose(
        _sums(found["east_cm"], 1e-2), playback.truth_m[kept, 0] - playback.truth_m[0, 0], atol=0.51e-2
    )
    assert kept[found["parts"][0]] == playback.parts[0]
    for run, shown in zip(playback.runs, found["channels"][0]["runs"], strict=True):
        off_m = (run.believed_m - playback.truth_m)[kept]
        np.testing.assert_allclose(_sums(shown["off_east_mm"], 1e-3), off_m[:, 0], atol=0.51e-3)
        np.testing.assert_allclose(_sums(shown["sent_ms"], 1e-3), playback.t_s[run.sent], atol=0.51e-3)
        kinds = {"u": MessageKind.UPDATE, "i": MessageKind.IDENTIFICATION, "k": MessageKind.KEEP_ALIVE}
        assert [kinds[letter] for letter in shown["what"]] == run.kind.tolist()
        assert [letter == "1" for letter in shown["lost"]] == run.lost.tolist()
        assert shown["member"] == run.in_use.tolist()


def test_a_long_trip_is_thinned_and_keeps_its_peaks_its_gap_and_the_manoeuvre() -> None:
    playback = _made(20_000)
    kept = played_samples(playback)
    assert kept.size < 6_000
    assert {0, 19_999, 9_999, 10_000} <= set(kept.tolist())
    assert np.isin(np.flatnonzero(np.abs(playback.t_s - playback.at_s) <= 60.0), kept).all()
    for run in playback.runs:
        error_m = playback.error_m(run)
        for part in np.array_split(np.arange(20_000), 40):
            assert np.nanmax(error_m[part]) == np.nanmax(error_m[np.intersect1d(part, kept)])


def test_a_thinned_path_stays_within_its_limit_at_every_sample() -> None:
    """A quick weave that lasts less than a stretch is kept too; played places are straight lines in time."""
    playback = _made(20_000)
    weave_m = np.where(np.arange(20_000) % 4_000 < 1_000, 3.0, 0.0) * np.sin(playback.t_s)
    playback = replace(playback, truth_m=playback.truth_m + weave_m[:, None] * np.array([0.0, 1.0]))
    kept = played_samples(playback)
    played_m: list[np.ndarray] = [
        np.interp(playback.t_s, playback.t_s[kept], playback.truth_m[kept, axis]) for axis in (0, 1)
    ]
    off_m = np.linalg.norm(np.array(played_m).T - playback.truth_m, axis=1)
    assert 0.1 < off_m.max() <= PATH_WITHIN_M
    assert kept.size < 8_000


def test_the_page_knows_where_samples_were_left_out(make_result: Make) -> None:
    """It tells no error there: `after_left_out` names every kept sample whose neighbour is missing."""
    playback = _made(20_000)
    kept = played_samples(playback)
    found = playback_document(replace(make_result(), playback=playback))
    told = set(found["after_left_out"])
    assert told == {at for at in range(1, kept.size) if kept[at] - 1 not in kept}
    assert found["step_ms"] == 100
    short = playback_document(replace(make_result(), playback=_made(500)))
    assert short["after_left_out"] == []


def test_a_short_trip_is_not_thinned() -> None:
    assert played_samples(_made(MOST_SAMPLES)).tolist() == list(range(MOST_SAMPLES))


def test_the_caption_says_what_was_left_out(make_result: Make) -> None:
    short, long = (replace(make_result(), playback=_made(samples)) for samples in (500, 20_000))
    assert "Every sample and every message is shown." in playback_caption(short)
    kept = played_samples(_made(20_000)).size
    assert f"Every message is shown, and {kept} of 20000 samples" in playback_caption(long)
    assert "40 % lost" in playback_caption(short)


def test_the_trip_opens_on_the_channel_that_loses_most_and_says_what_to_watch(make_result: Make) -> None:
    playback = _made(500)
    clear = tuple(replace(run, packet_error_ratio=0.0, lost=np.zeros_like(run.lost)) for run in playback.runs)
    both = replace(make_result(), playback=replace(playback, runs=clear + playback.runs))
    text = player(both)
    assert '<option value="1" selected>40 % lost</option>' in text
    assert '<option value="0">nothing lost</option>' in text
    assert text.index("after a lost message") < text.index("<canvas")
    alone = player(replace(make_result(), playback=replace(playback, runs=clear)))
    assert '<option value="0" selected>nothing lost</option>' in alone
    assert "between two messages" in alone
    assert "after a lost message" not in alone


def test_a_result_without_a_trip_to_play_has_nothing_of_it(make_result: Make, read_page: Any) -> None:
    page = read_page(report_document(make_result(), ()))
    assert page.data == []
    assert "section" not in page.tags
    with pytest.raises(ValueError, match="no playback"):
        playback_document(make_result())


def test_a_name_that_ends_a_script_ends_none(make_result: Make, read_page: Any) -> None:
    name = "</script><script>alert(1)</script><!--"
    page = read_page(report_document(replace(make_result(), playback=_made(50, trip=name)), ()))
    assert json.loads(page.data[0])["trip"] == name
    assert not page.open
    assert not any("alert" in one for one in page.scripts)


def test_the_policy_names_the_page_s_scripts_and_no_other(make_result: Make, read_page: Any) -> None:
    page = read_page(report_document(replace(make_result(), playback=_made(50)), ()))
    named = next(part for part in page.policy.split("; ") if part.startswith("script-src")).split()[1:]
    hashes = [base64.b64encode(hashlib.sha256(one.encode()).digest()).decode() for one in page.scripts]
    assert named == [f"'sha256-{one}'" for one in hashes]
    assert page.policy.startswith("default-src 'none';")


def test_uplot_is_as_it_was_published() -> None:
    folder = Path(report_document.__code__.co_filename).parent / "static"
    for name, wanted in UPLOT_SHA256.items():
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() == wanted, name
    assert "(v1.6.32)" in static_text("uPlot.iife.min.js")
    assert "MIT" in static_text("uPlot.LICENSE")
