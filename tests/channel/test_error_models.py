"""Claims about packet error against SINR."""

import numpy as np
import pytest
from scipy import special

from modelcast.channel.error_models import (
    SINR_DB as SINR_TABLE_DB,
)
from modelcast.channel.error_models import (
    AbstractErrorModel,
    NistErrorModel,
    TabulatedErrorModel,
    ThresholdErrorModel,
)
from modelcast.channel.table_error_model import ERROR_TABLES, TABLE_STEP_DB, TableErrorModel

MODELS: tuple[AbstractErrorModel, ...] = (
    NistErrorModel(),
    NistErrorModel(1, 3 / 4),
    NistErrorModel(4, 1 / 2),
    NistErrorModel(6, 2 / 3),
    TabulatedErrorModel.highway_los(),
    TabulatedErrorModel.highway_nlos(),
    TabulatedErrorModel.urban_los(),
    TabulatedErrorModel.crossing_nlos(),
    TabulatedErrorModel.sidelink_mcs5(),
    ThresholdErrorModel(6.5),
    TableErrorModel(),
    TableErrorModel(27.0, table_bytes=1458),
)
SINR_DB = np.linspace(-20.0, 45.0, 400)


@pytest.mark.parametrize("model", MODELS, ids=repr)
def test_error_falls_from_one_to_nothing_and_grows_with_size(model: AbstractErrorModel) -> None:
    small, large = (model.packet_error_ratio(SINR_DB, size) for size in (100, 1000))
    assert small[0] > 0.999
    assert small[-1] < 1e-3
    assert np.all(np.diff(small) <= 1e-9)
    assert np.all(large >= small - 1e-12)


def test_nist_is_the_union_bound_of_the_half_rate_code() -> None:
    sinr_db = np.array([2.5, 3.5, 5.0])
    raw = 0.5 * special.erfc(np.sqrt(10 ** (0.1 * sinr_db) / 2))
    d = np.sqrt(4 * raw * (1 - raw))
    weights = (36, 211, 1404, 11633, 77433, 502690, 3322763, 21292910, 134365911)
    bound = 0.5 * sum(weight * d ** (10 + 2 * k) for k, weight in enumerate(weights))
    bits = 22 + 8 * 300
    expected = 1 - (1 - np.minimum(bound, 1)) ** bits
    assert NistErrorModel().packet_error_ratio(sinr_db, 300) == pytest.approx(expected, abs=1e-3)


def test_implementation_loss_shifts_the_curve() -> None:
    ideal = NistErrorModel().packet_error_ratio(SINR_DB, 300)
    lossy = NistErrorModel(loss_db=5.0).packet_error_ratio(SINR_DB + 5.0, 300)
    assert lossy == pytest.approx(ideal, abs=1e-9)


def test_a_tabulated_curve_passes_through_its_points() -> None:
    curve = TabulatedErrorModel.highway_los()
    found = curve.packet_error_ratio(np.array(curve.sinr_db), 350)
    assert found == pytest.approx(curve.packet_errors, abs=1e-3)


def test_the_threshold_is_met_to_its_resolution() -> None:
    ratios = ThresholdErrorModel(6.5).packet_error_ratio(np.array([6.44, 6.51]), 300)
    assert ratios == pytest.approx([1.0, 0.0], abs=1e-3)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: NistErrorModel(3),
        lambda: NistErrorModel(2, 0.6),
        lambda: TabulatedErrorModel((0.0, 1.0), (0.2, 0.5)),
        lambda: TabulatedErrorModel((0.0,), (0.2,)),
        lambda: ThresholdErrorModel(float("nan")),
    ],
)
def test_impossible_settings_are_refused(wrong: object) -> None:
    with pytest.raises(ValueError, match="must"):
        wrong()  # type: ignore[operator]


@pytest.mark.parametrize(("rate_mbps", "table_bytes"), ERROR_TABLES)
def test_a_table_of_a_rate_passes_through_its_entries(rate_mbps: float, table_bytes: int) -> None:
    first_db, errors = ERROR_TABLES[rate_mbps, table_bytes]
    model = TableErrorModel(rate_mbps, table_bytes=table_bytes)
    at_db = first_db + TABLE_STEP_DB * np.arange(len(errors))
    found = 1.0 - np.exp(-np.interp(at_db, SINR_TABLE_DB, model.hazards()))
    assert found == pytest.approx(errors, rel=1e-6)
    assert model.packet_error_ratio(at_db[[0, -1]] + [-0.5, 0.5], 300).tolist() == pytest.approx([1.0, 0.0])
    assert np.all(np.diff(errors) < 0)


def test_ns3s_tables_are_3_db_more_sensitive_than_the_union_bound_at_6_mbps() -> None:
    sinr_db = np.arange(0.0, 10.0, 0.01)
    models = (TableErrorModel(), NistErrorModel())
    half = [np.interp(-0.5, -model.packet_error_ratio(sinr_db, 336), sinr_db) for model in models]
    assert half[1] - half[0] == pytest.approx(3.2, abs=0.3)


def test_both_tables_of_a_rate_agree_where_ns3_changes_from_one_to_the_other() -> None:
    sinr_db = np.arange(-5.0, 30.0, 0.01)
    for rate_mbps, table_bytes in ERROR_TABLES:
        found = TableErrorModel(rate_mbps, table_bytes=table_bytes).packet_error_ratio(sinr_db, 400)
        other = TableErrorModel(rate_mbps, table_bytes=1490 - table_bytes).packet_error_ratio(sinr_db, 400)
        halves = [np.interp(-0.5, -one, sinr_db) for one in (found, other)]
        assert abs(halves[0] - halves[1]) < 0.35


def test_what_there_is_no_table_of_is_told() -> None:
    with pytest.raises(ValueError, match=r"tables of \[3\.0, 6\.0, .* got 4\.5 and 32"):
        TableErrorModel(4.5)
    with pytest.raises(ValueError, match=r"got 6\.0 and 100"):
        TableErrorModel(table_bytes=100)
