"""Work shared out among processes comes back in its order, and survives the loss of one."""

from functools import partial
from pathlib import Path

import pytest

from modelcast.cli.shared_work import jobs_in_use, workers, workers_of
from modelcast.core.exceptions import ConfigError
from modelcast.corpora.executors.here import HereCrew
from modelcast.corpora.executors.processes import ProcessCrew, ProcessExecutor
from worker_tasks import die_at, doubled, fail_at


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_stand_in_the_order_of_the_work(jobs: int) -> None:
    with workers(jobs) as pool:
        assert list(pool.each(doubled, range(20))) == [2 * number for number in range(20)]
        assert sorted(pool.as_done(doubled, range(3))) == [(0, 0), (1, 2), (2, 4)]


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_a_piece_raises_is_raised(jobs: int) -> None:
    with workers(jobs) as pool, pytest.raises(ValueError, match="no 3"):
        list(pool.each(fail_at, range(5)))


def test_a_process_that_is_killed_costs_nothing(tmp_path: Path) -> None:
    with workers(2) as pool:
        found = list(pool.each(partial(die_at, tmp_path, {1: 1, 2: 2}), range(5)))
    assert found == [0, 2, 4, 6, 8]


def test_one_piece_of_work_needs_no_process() -> None:
    with workers_of(ProcessExecutor(2), 1) as one, workers_of(ProcessExecutor(2), 2) as two:
        assert (type(one.crew), type(two.crew)) == (HereCrew, ProcessCrew)


def test_a_negative_number_of_jobs_is_refused() -> None:
    assert jobs_in_use(3) == 3
    with pytest.raises(ConfigError, match="--jobs must be 0"):
        jobs_in_use(-1)
