"""Claims about the abstract radio alone; what holds of every radio is in `test_radio_conformance.py`."""

import numpy as np
import pytest
from scipy import stats

from modelcast.channel.radio import Transmissions
from modelcast.channel.tabulated import ReceptionTable, TabulatedRadio

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
    """1000 messages of 440 us in a second are a load of 0.44; a binomial test at each distance."""
    radio = TabulatedRadio(TABLE)
    state = radio.init(4, np.random.default_rng(3))
    place_m = np.array([[0.0, 0.0], [50.0, 0.0], [150.0, 0.0], [250.0, 0.0]])
    heard, after = radio.step(state, batch(1000), place_m, 1.0)
    load = 1000 * 440e-6
    assert radio.channel_busy_ratio(after) == pytest.approx(load)
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
        lambda: TabulatedRadio(TABLE, 0.0),
        lambda: TabulatedRadio(TABLE).step(
            TabulatedRadio(TABLE).init(1, np.random.default_rng(0)), batch(0), np.zeros((1, 2)), 0.0
        ),
    ],
)
def test_impossible_settings_are_refused(wrong: object) -> None:
    with pytest.raises(ValueError, match="must"):
        wrong()  # type: ignore[operator]
