"""A made-up evaluation, of any size, that looks like a real one."""

from collections.abc import Callable, Sequence
from html.parser import HTMLParser

import numpy as np
import pytest

from modelcast.study.result import (
    RATES,
    TRACKING,
    Ecdf,
    EvaluationResult,
    Manoeuvre,
    SampleBlock,
    Timeline,
    TripRow,
)
from modelcast.study.table import Row

POLICIES = (
    ("mbc", None),
    ("baseline", None),
    ("baseline-matched", "total"),
    ("baseline-matched", "update"),
    ("baseline-periodic", "total"),
    ("baseline-periodic", "update"),
    ("free", None),
    ("free-matched", "total"),
    ("free-matched", "update"),
)
VOID = {"input", "meta", "img", "br"}
SCALE = {
    "mbc": 0.8,
    "baseline": 1.0,
    "baseline-matched": 1.1,
    "baseline-periodic": 1.5,
    "free": 0.85,
    "free-matched": 0.9,
}
BANKS = {"mbc": "cv+gp", "free": "free", "free-matched": "free"}


class Page(HTMLParser):
    """Tags in order, addresses they point to, text, scripts and policy; elements must be closed in order."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.addresses: list[str] = []
        self.text = ""
        self.scripts: list[str] = []
        self.data: list[str] = []
        self.policy = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:  # noqa: D102
        self.tags.append(tag)
        self.addresses += [value or "" for name, value in attrs if name in {"src", "href", "data", "action"}]
        given = dict(attrs)
        if given.get("http-equiv") == "Content-Security-Policy":
            self.policy = given["content"] or ""
        if tag == "script":
            (self.data if given.get("type") == "application/json" else self.scripts).append("")
            self._filled = self.data if given.get("type") == "application/json" else self.scripts
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:  # noqa: D102
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:  # noqa: D102
        if self.open[-1:] == ["script"]:
            self._filled[-1] += data
        else:
            self.text += data


@pytest.fixture(scope="module", autouse=True)
def letters_of_pdfs() -> None:
    """Leave them as users get them."""


@pytest.fixture(scope="session")
def read_page() -> Callable[[str], Page]:
    """What takes a page apart."""

    def read(text: str) -> Page:
        page = Page()
        page.feed(text)
        return page

    return read


def build_result(
    thresholds: Sequence[float] = (0.2, 0.3, 0.4, 0.5),
    ratios: Sequence[float] = (0.0, 0.2, 0.4, 0.6),
    trips: Sequence[str] = ("kerbside/1", "ring-road/17", "<script>alert(1)</script>/$3"),
    *,
    seeds: int = 5,
    timeline: bool = True,
    manoeuvre: bool = True,
    steps: int = 300,
) -> EvaluationResult:
    names = ("all", *trips)
    return EvaluationResult(
        {"keep_alive_s": 2.0, "seed": 1, "thresholds_m": tuple(thresholds), "bank": "cv+gp"},
        trips=tuple(_trip(name, at) for at, name in enumerate(trips)),
        rates=RATES.table(
            _rate(n, at, p, th)
            for at, n in enumerate(names)
            for p in ("mbc", "baseline", "free")
            for th in thresholds
        ),
        tracking=TRACKING.table(
            _tracking(name, policy, basis, at=at, threshold_m=th, ratio=ratio, seeds=seeds)
            for at, name in enumerate(names)
            for policy, basis in POLICIES
            for th in thresholds
            for ratio in ratios
        ),
        ecdfs=tuple(
            _ecdf(p, basis, th, ratio) for p, basis in POLICIES for th in thresholds for ratio in ratios
        ),
        timeline=_timeline(trips[0], steps) if timeline else None,
        manoeuvre=_manoeuvre(trips[0]) if manoeuvre else None,
        events={
            "trip": np.repeat(np.array(trips), 4),
            "policy": np.tile(np.array(["mbc", "mbc", "baseline", "mbc"]), len(trips)),
            "bank": np.full(4 * len(trips), "cv+gp"),
            "threshold_m": np.full(4 * len(trips), thresholds[0]),
            "t_s": np.tile([0.0, 1.5, 1.0, 2.5], len(trips)),
            "kind": np.tile(np.array(["update", "identification", "update", "update"]), len(trips)),
            "sub_model": np.tile(np.array(["cv", "gp", "cv", "cv"]), len(trips)),
            "size_bytes": np.full(4 * len(trips), 40),
            "airtime_s": np.full(4 * len(trips), 0.36e-3),
        },
        samples=tuple(_block(name, basis, ratios) for name in trips for basis in (None, "total")),
        failures={"broken/<b>7</b>": "fewer than 11 samples [bold]", "broken/8": "time does not increase"},
    )


def _trip(name: str, at: int) -> TripRow:
    return TripRow(
        name,
        "csv",
        600.0 + at,
        standing_s=30.0,
        vehicles=1,
        samples=6000,
        dt_s=0.1,
        gaps=at,
        resampled=False,
        protocol="sensor" if at == 1 else "recorded",
        conditioned=at == 1,
        velocity_estimator="speed-heading",
        grid_m=(0.0, 0.01),
        rows=6010,
        skipped={"no fix": 10} if at else {},
        repaired={"wrapped heading": 2},
        conditioning={"sigma_m": 0.04} if at == 1 else None,
        warnings={"rate": "sampled at <5> Hz"} if at else {},
    )


def _block(trip: str, basis: str | None, ratios: Sequence[float]) -> SampleBlock:
    errors = np.arange(len(ratios) * 2 * 5, dtype=np.float32).reshape(len(ratios), 2, 5) / np.float32(100)
    errors[0, 0, 2] = np.nan
    names = ("tracking_error_m", "tracking_error_before_m", "along_track_m", "cross_track_m")
    return SampleBlock(
        trip,
        "mbc" if basis is None else "baseline-matched",
        "cv+gp",
        basis,
        0.2,
        tuple(ratios),
        0.1 * np.arange(5),
        {name: errors + np.float32(at) for at, name in enumerate((*names, "information_age_s"))},
    )


def _rate(trip: str, at: int, policy: str, threshold_m: float) -> Row:
    start, slope = {"mbc": (1.9, 1.6), "free": (1.95, 1.7), "baseline": (2.0, 2.0)}[policy]
    total = (start - slope * threshold_m) * (1 + 0.25 * np.sin(at))
    identifications = 0.3 * total if policy == "mbc" else 0.0
    return RATES.row(
        trip=trip,
        policy=policy,
        bank=BANKS.get(policy, "cv"),
        threshold_m=threshold_m,
        updates=round(600 * (total - identifications)),
        identifications=round(600 * identifications),
        duration_s=600.0,
        update_rate_hz=total - identifications,
        identification_rate_hz=identifications,
        total_rate_hz=total,
        moving_total_rate_hz=1.05 * total,
        bytes_per_s=40 * total,
        airtime_per_s=0.36e-3 * total,
    )


def _tracking(
    trip: str, policy: str, basis: str | None, *, at: int, threshold_m: float, ratio: float, seeds: int
) -> Row:
    p90 = SCALE[policy] * (1 + 0.2 * np.cos(at)) * (0.9 * threshold_m + (1 + threshold_m) * ratio**2)
    p90 *= 1.1 if basis == "update" else 1.0
    band = 0.06 * p90 if seeds > 1 else None
    return TRACKING.row(
        trip=trip,
        policy=policy,
        bank=BANKS.get(policy, "cv"),
        rate_basis=basis,
        threshold_m=threshold_m,
        own_threshold_m=None if policy == "baseline-periodic" else threshold_m,
        packet_error_ratio=ratio,
        seeds=seeds,
        samples=6000 * seeds,
        excluded_samples=3,
        message_rate_hz=1.4,
        pte_mean_m=0.5 * p90,
        pte_p50_m=0.4 * p90,
        pte_p90_m=p90,
        pte_p90_low_m=None if band is None else p90 - band,
        pte_p90_high_m=None if band is None else p90 + band,
        pte_p95_m=1.3 * p90,
        pte_p99_m=float("nan") if trip == "all" else 2 * p90,
        pte_before_p90_m=1.1 * p90,
        along_p90_m=0.9 * p90,
        cross_p90_m=0.4 * p90,
        beyond_lane_ratio=0.01,
        inter_packet_gap_p50_s=0.7,
        inter_packet_gap_p95_s=None,
        information_age_mean_s=0.5,
        information_age_p95_s=1.4,
    )


def _ecdf(policy: str, basis: str | None, threshold_m: float, ratio: float) -> Ecdf:
    probability = np.linspace(0.0, 1.0, 400)
    p90 = SCALE[policy] * (0.9 * threshold_m + (1 + threshold_m) * ratio**2)
    error_m = p90 * np.clip(-np.log1p(-0.999 * probability) / 2.3, 0.0, None) ** 1.3
    error_m[probability < 0.08] = 0.0
    return Ecdf(policy, basis, threshold_m, ratio, error_m, probability)


def _timeline(trip: str, steps: int) -> Timeline:
    t_s = 0.1 * np.arange(steps)
    rng = np.random.default_rng(7)
    errors = np.zeros((steps, 2))
    in_use, updates, identifications = np.zeros(steps, dtype=np.int64), [0.0], []
    age, growth, used = 0, rng.uniform(0.01, 0.05, 2), 0
    for k in range(steps):
        errors[k] = growth * age**1.4 * 0.4 + 0.01 * rng.random(2)
        age += 1
        if (errors[k] >= 0.3).all():
            updates.append(t_s[k])
            age, growth, used = 1, rng.uniform(0.005, 0.06, 2), 0
        elif errors[k, used] >= 0.3:
            used = 1 - used
            identifications.append(t_s[k])
        in_use[k] = used
    errors[:8, 1] = np.nan
    return Timeline(
        trip, 0.3, ("cv", "gp"), t_s, errors, in_use, np.array(updates), np.array(identifications)
    )


def _manoeuvre(trip: str) -> Manoeuvre:
    def path(t_s: np.ndarray, rate: float, speed: float = 9.0) -> np.ndarray:
        turned = rate * np.clip(t_s, 0, None) ** 1.5
        step = np.gradient(t_s) * speed
        xy = np.stack([np.cumsum(step * np.cos(turned)), np.cumsum(step * np.sin(turned))], axis=1)
        return xy - xy[np.argmin(np.abs(t_s))] + [310.0, -40.0]

    horizons = np.linspace(0.0, 4.0, 41)
    truth = path(horizons, 0.25)
    predicted = {"cv": path(horizons, 0.0), "gp": path(horizons, 0.2)}
    survival = {}
    for name, positions in predicted.items():
        failed = np.flatnonzero(np.hypot(*(positions - truth).T) >= 0.3)
        survival[name] = float(horizons[failed[0]]) if failed.size else float("inf")
    history = path(np.linspace(-0.9, 0.0, 10), 0.0)
    return Manoeuvre(trip, 21.3, history, truth, horizons, predicted, survival, 0.3)


@pytest.fixture(name="make_result")
def _make_result() -> Callable[..., EvaluationResult]:
    return build_result
