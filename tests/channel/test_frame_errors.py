"""Claims about errors of frames by size: what is decided early is what the luck itself would decide."""

import numpy as np
import pytest

from modelcast.channel.error_kernels import hazard_at, survives
from modelcast.channel.error_models import (
    AbstractErrorModel,
    NistErrorModel,
    TabulatedErrorModel,
    ThresholdErrorModel,
)
from modelcast.channel.frame_errors import CELLS, frame_errors

SIZES = np.maximum(np.arange(401), 1)


@pytest.mark.parametrize(
    "model",
    [TabulatedErrorModel.sidelink_mcs5(), ThresholdErrorModel(5.0), NistErrorModel(2, 0.5)],
    ids=["table", "step", "bits"],
)
def test_a_frame_survives_where_its_luck_outlasts_its_hazard(model: AbstractErrorModel) -> None:
    errors = frame_errors(model, SIZES)
    rng = np.random.default_rng(4)
    early = 0
    for _ in range(4000):
        size, chance = int(rng.integers(1, 401)), float(rng.random())
        ratio = float(10.0 ** (0.1 * rng.uniform(-35.0, 55.0)))
        luck = -np.log(1.0 - chance)
        expected = errors.units[size] * hazard_at(ratio, errors.hazard) <= luck
        assert survives(ratio, chance, size, errors) == expected
        received, lost = errors.certain[size // 16, int(chance * CELLS)]
        assert lost < received
        early += not lost <= ratio < received
    assert early > 3500


def test_what_is_hopeless_or_safe_leaves_nothing_to_luck() -> None:
    errors = frame_errors(TabulatedErrorModel.sidelink_mcs5(), SIZES)
    for size in (1, 190, 400):
        assert survives(errors.safe_ratio, 2.0**-53, size, errors)
        if errors.hopeless_ratio[size] > 0.0:
            below = 0.99 * float(errors.hopeless_ratio[size])
            assert not survives(below, 1.0 - 2.0**-53, size, errors)
