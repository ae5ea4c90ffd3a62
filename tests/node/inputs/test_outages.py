"""Dead reckoning on real trips stays within the ellipse it states."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from modelcast.io.trips import read_trips

AGES_S = np.array([1.0, 3.0, 5.0])
LEAST_WITHIN_RATIO = 0.9
"""Of a 95 % ellipse, in some forty outages of a trip; the figure's own standard deviation is 0.03."""
LARGEST_P95_M = 1.5
"""After 5 s; measured: 1.04 m on both."""


@pytest.fixture(scope="module")
def outages() -> ModuleType:
    """The script of ``validation``."""
    path = Path(__file__).parents[3] / "validation" / "outages.py"
    spec = importlib.util.spec_from_file_location("outages", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(path.parent))
    spec.loader.exec_module(module)
    sys.path.pop(0)
    return module


@pytest.mark.real
@pytest.mark.parametrize("name", ["comma2k19", "smartloc"])
def test_errors_grow_and_stay_within_the_stated_ellipse(outages, data_folder: Path, name: str):
    (trip,) = read_trips(data_folder / name)
    errors = outages.outage_errors(trip, AGES_S)
    assert errors[:, 3].mean() >= LEAST_WITHIN_RATIO
    medians = [np.median(errors[errors[:, 0] == age_s], axis=0) for age_s in AGES_S]
    assert medians[0][1] < medians[1][1] < medians[2][1]
    assert medians[0][2] < medians[1][2] < medians[2][2]
    assert np.quantile(errors[errors[:, 0] == 5.0][:, 1], 0.95) < LARGEST_P95_M
