"""Claims about the abstract radio alone; what holds of every radio is in `test_radio_conformance.py`."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.path_loss import LogDistance
from modelcast.channel.propagation import NakagamiFading, Propagation, Shadowing, StreetGrid
from modelcast.channel.radio import Transmissions
from modelcast.channel.sensed_share import MARGIN_DB, sensed_shares
from modelcast.channel.tabulated import ReceptionTable, TabulatedRadio, measured_table

CLEAR = Propagation(LogDistance(2.0, 40.0), None, None)
"""A frame of 20 dBm is at -85 dBm after 1778 m, with nothing left to chance."""

TABLE = ReceptionTable(np.array([0.0, 0.5]), np.array([[0.9, 0.6], [0.5, 0.2]]), bin_m=100.0)


def batch(number: int) -> Transmissions:
    return Transmissions(
        np.zeros(number, dtype=np.int64),
        np.linspace(0.0, 0.9, number),
        size_bytes=np.full(number, 300, dtype=np.int64),
        power_dbm=np.full(number, 20.0),
        message_id=np.arange(number, dtype=np.int64),
    )


def test_reception_follows_the_table_between_its_loads() -> None:
    """1000 messages of 448 us in a second are a load of 0.448 where all are sensed; a binomial test each."""
    radio = TabulatedRadio(TABLE, CLEAR)
    state = radio.init(4, np.random.default_rng(3))
    place_m = np.array([[0.0, 0.0], [50.0, 0.0], [150.0, 0.0], [250.0, 0.0]])
    heard, after = radio.step(state, batch(1000), place_m, 1.0)
    load = 1000 * 448e-6
    assert after.load_ratio == pytest.approx(load)
    for receiver, near, far in ((1, 0.9, 0.5), (2, 0.6, 0.2)):
        expected = near + (far - near) * load / 0.5
        found = int((heard.receiver == receiver).sum())
        assert stats.binomtest(found, 1000, expected).pvalue > 0.001
    assert not np.any(heard.receiver == 3)
    assert heard.outcomes.sum() == 2000
    assert np.all(np.isnan(heard.rssi_dbm))


def test_a_table_made_of_counts_is_their_ratio() -> None:
    counts = np.array([[[9, 0, 1, 0, 0], [5, 0, 5, 0, 0]], [[4, 0, 1, 5, 0], [1, 0, 5, 4, 0]]])
    table = ReceptionTable.from_outcomes(np.array([0.1, 0.4]), counts, bin_m=50.0)
    assert table.reception_ratios.tolist() == [[0.9, 0.5], [0.4, 0.1]]
    with pytest.raises(ValueError, match="every bin"):
        ReceptionTable.from_outcomes(np.array([0.1, 0.4]), 0 * counts, bin_m=50.0)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: ReceptionTable(np.array([0.5, 0.1]), np.ones((2, 2))),
        lambda: ReceptionTable(np.array([0.5]), np.ones((2, 2))),
        lambda: ReceptionTable(np.array([0.5]), np.full((1, 2), 1.5)),
        lambda: ReceptionTable(np.array([0.5]), np.ones((1, 2)), busy_ratios=np.ones(2)),
        lambda: ReceptionTable(np.array([0.1, 0.5]), np.ones((2, 2)), busy_ratios=np.array([0.4, 0.1])),
        lambda: TabulatedRadio(TABLE, load_dbm=np.nan),
        lambda: TabulatedRadio(TABLE, antenna_gain_db=np.inf),
        lambda: TabulatedRadio(TABLE, rate_mbps=0.0),
        lambda: TabulatedRadio(TABLE, rate_mbps=0.01),
        lambda: TabulatedRadio(TABLE, preamble_s=-1e-6),
        lambda: TabulatedRadio(TABLE).step(
            TabulatedRadio(TABLE).init(1, np.random.default_rng(0)), batch(0), np.zeros((1, 2)), 0.0
        ),
    ],
)
def test_impossible_settings_are_refused(wrong: object) -> None:
    with pytest.raises(ValueError, match="must"):
        wrong()  # type: ignore[operator]


def test_antennas_at_both_ends_count_as_so_much_power() -> None:
    """3 dB at either end against 6 dBm more."""
    fitted = TabulatedRadio(TABLE, antenna_gain_db=3.0)
    gained = load_at(fitted, 100.0, 180.0, power_dbm=14.0)
    assert gained.tolist() == pytest.approx(load_at(TabulatedRadio(TABLE), 100.0, 180.0).tolist())
    assert gained[2] > load_at(TabulatedRadio(TABLE), 180.0, power_dbm=14.0)[1]


def load_at(radio: TabulatedRadio, *distance_m: float, power_dbm: float = 20.0) -> np.ndarray:
    """Loads of vehicles at distances from one that sends 1000 messages in a second, itself first."""
    place_m = np.array([[0.0, 0.0], *([one, 0.0] for one in distance_m)])
    state = radio.init(len(place_m), np.random.default_rng(1))
    sent = batch(1000)
    sent = replace(sent, power_dbm=np.full(sent.size, power_dbm))
    return radio.step(state, sent, place_m, 1.0)[1].load_ratio


def test_without_chance_a_frame_is_sensed_where_its_power_is_above_the_bound() -> None:
    """With 40 dB at 1 m and 20 dB a decade 20 dBm reach -85 dBm after 1778 m, 10 dBm after 562 m."""
    radio = TabulatedRadio(TABLE, CLEAR)
    assert load_at(radio, 1700.0, 1950.0).tolist() == pytest.approx([0.448, 0.448, 0.0])
    assert load_at(radio, 530.0, 600.0, power_dbm=10.0).tolist() == pytest.approx([0.448, 0.448, 0.0])
    assert load_at(TabulatedRadio(TABLE, CLEAR, load_dbm=-75.0), 530.0, 600.0)[1:].tolist() == [
        pytest.approx(0.448),
        0.0,
    ]


@pytest.mark.parametrize("distance_m", [20.0, 90.0, 180.0, 260.0])
def test_the_share_sensed_is_that_of_drawn_gains(distance_m: float) -> None:
    """40,000 draws of fresh shadowing and fading; five standard deviations of their share."""
    radio = TabulatedRadio(TABLE)
    found = load_at(radio, distance_m)[1] / 0.448
    rng = np.random.default_rng(5)
    propagation, draws = radio.propagation, 40_000
    median_db = 20.0 - propagation.path_loss.loss_db(np.array([distance_m]))[0]
    shadow_db = 3.0 * rng.standard_normal(draws)
    fading = NakagamiFading().draw(np.full(draws, distance_m), rng)
    share = np.mean(median_db + shadow_db + 10.0 * np.log10(fading) >= -85.0)
    assert found == pytest.approx(share, abs=5.0 * 0.5 / np.sqrt(draws) + 1e-3)


@pytest.mark.parametrize(
    ("shadowing", "fading"),
    [(None, None), (Shadowing(), None), (None, NakagamiFading()), (Shadowing(), NakagamiFading())],
)
def test_shares_rise_from_none_to_all(shadowing: Shadowing | None, fading: NakagamiFading | None) -> None:
    shares = sensed_shares(Propagation(shadowing=shadowing, fading=fading))
    assert np.all(np.diff(shares, axis=2) >= -1e-12)
    assert shares[..., 0] == pytest.approx(0.0, abs=1e-9)
    assert shares[..., -1] == pytest.approx(1.0, abs=10.0 ** (-MARGIN_DB / 10.0) * 2.0)


def test_buildings_keep_frames_from_being_sensed() -> None:
    streets = Propagation(streets=StreetGrid(), nlos=LogDistance(4.0, 60.0), shadowing=None, fading=None)
    radio, open_ground = TabulatedRadio(TABLE).within(streets), TabulatedRadio(TABLE)
    place_m = np.array([[0.0, 125.0], [125.0, 0.0]])
    loads = [
        one.step(one.init(2, np.random.default_rng(0)), batch(1000), place_m, 1.0)[1].load_ratio[1]
        for one in (radio, open_ground)
    ]
    assert loads[0] == 0.0 < loads[1]


def test_the_busy_ratio_of_a_load_is_that_of_the_table() -> None:
    table = ReceptionTable(np.array([0.2, 0.6]), np.ones((2, 1)), busy_ratios=np.array([0.19, 0.51]))
    load = np.array([0.0, 0.1, 0.2, 0.4, 0.6, 1.6])
    assert table.busy_ratio(load).tolist() == pytest.approx(
        [0.0, 0.095, 0.19, 0.35, 0.51, 1.0 - 0.49 * np.exp(-1.0)]
    )
    assert TABLE.busy_ratio(load).tolist() == pytest.approx((1.0 - np.exp(-load)).tolist())


@pytest.mark.slow
@pytest.mark.parametrize(("size_bytes", "power_dbm", "density_per_km"), [(400, 20.0, 250), (250, 10.0, 400)])
def test_it_finds_the_channel_as_busy_as_the_radio_it_was_measured_of(
    size_bytes: int, power_dbm: float, density_per_km: int
) -> None:
    """At sizes and powers that the table was not made at; 0.015 is what four placements leave to chance."""
    detailed, radio = Dsrc(), TabulatedRadio(measured_table())
    found = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        vehicles = 2 * density_per_km
        place_m = np.column_stack([rng.uniform(0.0, 2000.0, vehicles), 4.0 * rng.integers(0, 6, vehicles)])
        states = detailed.init(vehicles, rng), radio.init(vehicles, rng)
        middle = np.abs(place_m[:, 0] - 1000.0) < 600.0
        phase = rng.uniform(0.0, 0.095, vehicles)
        for k in range(4):
            ready_s = 0.1 * k + phase + rng.uniform(0.0, 0.005, vehicles)
            order = np.argsort(ready_s)
            sent = Transmissions(
                order,
                ready_s[order],
                size_bytes=np.full(vehicles, size_bytes),
                power_dbm=np.full(vehicles, power_dbm),
                message_id=k * vehicles + order,
            )
            until_s = round(0.1 * (k + 1), 6)
            states = (
                detailed.carry(states[0], sent, place_m, until_s)[1],
                radio.step(states[1], sent, place_m, until_s)[1],
            )
        busy = detailed.channel_busy_ratio(states[0]), radio.channel_busy_ratio(states[1])
        found.append([one[middle].mean() for one in busy])
    measured, tabulated = np.mean(found, axis=0)
    assert tabulated == pytest.approx(measured, abs=0.015)
