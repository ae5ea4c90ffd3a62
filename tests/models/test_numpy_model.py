"""Claims about sub-models in plain NumPy: the same as compiled ones, errors told, rows, state, processes."""

import gc
import pickle
import re
import sys
import threading
import types
import warnings
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from tests.models.numpy_models import CALLS, Coasting, Following, Smoothed

from modelcast.core.exceptions import ModelcastWarning, SubModelError
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel, Windows, made_functions
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.context_columns import CONTEXT_COLUMNS, LEADER_GAP
from modelcast.models.members import ReadyBank
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.models.predicted_path import PredictedPath
from modelcast.models.row_independence import made_up_windows
from modelcast.models.trusted import Trusted
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.trips.trajectory import Trajectory

WINDOWS = made_up_windows(8, dt_s=0.1)
HORIZONS_S = np.array([0.0, 0.35, 1.0, 4.0])
LOOP = AbstractSubModel
"""Its methods go through the compiled loops, row by row, whatever a sub-model does itself."""


def walk(trip: Trajectory, bank: Bank, threshold_m: float = 0.3) -> Any:
    """Messages of a policy over a trip."""
    return TripRuntime(trip, bank, velocity_estimator_for(trip)).run(ErrorDriven(threshold_m))


@pytest.mark.slow
def test_it_sends_the_messages_of_the_compiled_one(drive: Trajectory) -> None:
    plain, compiled = (walk(drive, Bank((one,))) for one in (Coasting(), ConstantVelocity()))
    assert plain.updates == compiled.updates > 10
    assert np.array_equal(plain.kind, compiled.kind)


@pytest.mark.parametrize(
    "model", [Coasting(), Smoothed(), PredictedPath(Coasting()), Trusted(Coasting(), 0.5)], ids=str
)
def test_batches_and_compiled_loops_say_the_same(model: AbstractSubModel) -> None:
    parameters = model.fit(WINDOWS)
    assert np.array_equal(LOOP.fit(model, WINDOWS), parameters)
    ages_s = np.resize(HORIZONS_S, len(parameters))
    for one, at in (("predict", HORIZONS_S), ("predict_at", ages_s)):
        together = getattr(model, one)(parameters, at, dt_s=0.1)
        assert np.array_equal(getattr(LOOP, one)(model, parameters, at, dt_s=0.1), together)


def test_the_path_of_it_is_that_of_the_compiled_one() -> None:
    paths = [PredictedPath(one).fit(WINDOWS) for one in (Coasting(), ConstantVelocity())]
    assert np.array_equal(*paths)


def test_its_covariance_is_that_of_constant_velocity_where_it_says_none() -> None:
    velocity = ConstantVelocity()
    found = Coasting().covariance(Coasting().fit(WINDOWS), HORIZONS_S, dt_s=0.1)
    assert np.array_equal(found, velocity.covariance(velocity.fit(WINDOWS), HORIZONS_S, dt_s=0.1))


FAULTS = [
    ("raises", SubModelError, "The sub-model coasting failed in fit_batch: ZeroDivisionError: nothing moves"),
    ("leaves", SubModelError, "The sub-model coasting failed in fit_batch: SystemExit: 3"),
    ("nan", SubModelError, "gave nan from fit_batch in row 0 at velocity_north_mps: every number must be"),
    ("shape", SubModelError, "gave (1, 1) from fit_batch, wanted (1, 2): a row each"),
    ("text", SubModelError, "The sub-model coasting gave no array of numbers from fit_batch"),
    ("stops", KeyboardInterrupt, "enough"),
]


@pytest.mark.parametrize("around", [lambda one: one, PredictedPath, lambda one: Trusted(one, 1.0)])
@pytest.mark.parametrize(("fault", "kind", "told"), FAULTS, ids=[one[0] for one in FAULTS])
def test_what_goes_wrong_comes_out_of_the_compiled_loop(
    fault: str, kind: type[BaseException], told: str, around: Callable[[AbstractSubModel], AbstractSubModel]
) -> None:
    model = around(Coasting(fault))
    with pytest.raises(kind, match=re.escape(told)) as caught:
        LOOP.fit(model, Windows(WINDOWS.samples[:1], dt_s=0.1))
    if fault == "raises":
        assert isinstance(caught.value.__cause__, ZeroDivisionError)


def test_what_goes_wrong_comes_out_of_an_evaluation(drive: Trajectory) -> None:
    with pytest.raises(SubModelError, match="ZeroDivisionError: nothing moves"):
        walk(drive, Bank((Coasting("raises"), ConstantVelocity())))
    assert walk(drive, Bank((Coasting(),))).updates > 10


def test_the_row_and_the_number_of_a_batch_are_named() -> None:
    with (
        np.errstate(all="ignore"),
        pytest.raises(SubModelError, match=r"gave (inf|nan|-inf) from .* row 0 at"),
    ):
        Coasting("infinite").predict(np.ones((3, 2)), HORIZONS_S, dt_s=0.1)

    parameters = np.ones((3, 2))
    parameters[2, 1] = np.inf
    with pytest.raises(
        SubModelError, match="gave inf from predict_batch in row 2 at 0, 1: every number must"
    ):
        Coasting().predict(parameters, np.array([1.0]), dt_s=0.1)


def test_each_thread_gets_its_own_failure() -> None:
    one = Windows(WINDOWS.samples[:1], dt_s=0.1)
    ready = threading.Barrier(2)
    found: dict[str, str] = {}

    def fail(fault: str) -> None:
        ready.wait()
        for _ in range(200):
            with pytest.raises(SubModelError) as caught:
                LOOP.fit(Coasting(fault), one)
            found[fault] = found.get(fault, str(caught.value))
            assert found[fault] == str(caught.value)

    threads = [threading.Thread(target=fail, args=(fault,)) for fault in ("raises", "shape")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert "nothing moves" in found["raises"]
    assert "wanted (1, 2)" in found["shape"]


def test_rows_that_change_one_another_are_called_one_by_one() -> None:
    model = Coasting("rows")
    with pytest.warns(
        ModelcastWarning, match="rows of fit_batch of the sub-model coasting change one another"
    ):
        assert model.row_dependence(0.1) == ("fit_batch",)
    assert not model.fit(WINDOWS).any()  # each minus the mean of itself alone
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model.fit(WINDOWS)  # it is said once
    assert Coasting().row_dependence(0.1) == ()


def test_a_batch_whose_rows_stand_alone_is_one_call() -> None:
    for model, sizes in ((Coasting(), [67]), (Coasting("rows"), [1] * 67)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelcastWarning)
            model.row_dependence(0.1)
        CALLS.clear()
        model.fit(WINDOWS)
        assert sizes == CALLS


def test_a_sub_model_that_does_not_pickle_is_refused() -> None:
    @dataclass(frozen=True, slots=True)
    class Hidden(Coasting):
        """A class of a function has no place that another process finds."""

    with pytest.raises(SubModelError, match="goes to other processes and must pickle"):
        made_functions(Hidden(), 0.1)


def test_state_is_carried_through_a_trip(drive: Trajectory) -> None:
    model = Smoothed()
    samples = TripRuntime(drive, Bank((model,)), velocity_estimator_for(drive)).sensed.samples[
        0, : drive.t_s.size
    ]
    states = samples[:, SAMPLE_COLUMNS:]
    assert states.shape[1] == 2
    expected = samples[0, 2:4]
    for at in range(len(samples)):
        expected = samples[at, 2:4] if at == 0 else expected + 0.2 * (samples[at, 2:4] - expected)
        assert np.allclose(states[at], expected, rtol=0.0, atol=1e-12)
    whole = Windows(samples[None, :30, :SAMPLE_COLUMNS].copy(), dt_s=drive.dt_s)
    assert np.array_equal(model.fit(whole)[0], states[29])
    assert walk(drive, Bank((model, ConstantVelocity()))).updates > 0


def test_context_is_given_to_what_reads_it() -> None:
    model = Following()
    samples = np.zeros((3, 2, SAMPLE_COLUMNS + CONTEXT_COLUMNS))
    samples[..., SAMPLE_COLUMNS + LEADER_GAP] = [[1.0, 7.0], [1.0, 8.0], [1.0, 9.0]]
    windows = Windows(samples, dt_s=0.1)
    for fit in (model.fit, lambda one: LOOP.fit(model, one)):
        assert fit(windows)[:, 0].tolist() == [7.0, 8.0, 9.0]
        assert fit(Windows(samples[..., :SAMPLE_COLUMNS].copy(), dt_s=0.1))[:, 0].tolist() == [-1.0] * 3
    assert ReadyBank.of(Bank((model,)), 0.1).reads_context


def test_addresses_stay_behind() -> None:
    functions = made_functions(Coasting(), 0.1)
    there = pickle.loads(pickle.dumps(functions))  # noqa: S301 - our own
    assert not functions.constants.any()
    assert np.count_nonzero(there.addressed) == np.count_nonzero(functions.addressed) == len(functions.calls)
    assert not {*there.addressed} & {*functions.addressed} - {0.0}  # each has its own
    assert there.calls == functions.calls
    assert made_functions(Coasting("nan"), 0.1).calls != functions.calls


NOTEBOOK = """
from dataclasses import dataclass
from typing import Any
from tests.models.numpy_models import Coasting

def scale(values):
    return {factor} * values

@dataclass(frozen=True, slots=True)
class Cell(Coasting):
    change: Any = None
    name = "cell"

    def fit_batch(self, windows):
        found = windows.velocities_mps[:, -1]
        return {factor} * found if self.change is None else self.change(found)
"""


@pytest.fixture
def cell(monkeypatch: pytest.MonkeyPatch) -> Callable[[float | str], Any]:
    """Run a cell of a notebook again, with another number in it: a class and a function of the same names."""
    notebook = types.ModuleType("notebook_of_a_test")
    monkeypatch.setitem(sys.modules, notebook.__name__, notebook)

    def run(factor: float | str) -> Any:
        exec(NOTEBOOK.format(factor=factor), notebook.__dict__)  # noqa: S102 - our own text
        return notebook

    return run


@pytest.mark.parametrize("field", [False, True], ids=["class", "function in a field"])
def test_what_is_defined_again_under_its_name_runs_its_new_code(
    cell: Callable[[float | str], Any], field: bool
) -> None:
    expected = WINDOWS.velocities_mps[:, -1]
    kept: Any = None
    for factor in (1.0, 2.0, 3.0):
        notebook = cell(factor)
        if kept is None or not field:
            kept = notebook.Cell
        notebook.Cell = kept
        model = kept(change=notebook.scale if field else None)
        assert np.array_equal(LOOP.fit(model, WINDOWS), factor * expected)


def test_what_is_defined_again_is_looked_at_again(cell: Callable[[float | str], Any]) -> None:
    assert cell(1.0).Cell().row_dependence(0.1) == ()
    with pytest.warns(ModelcastWarning, match="of the sub-model cell change one another"):
        assert cell("found.mean()").Cell().row_dependence(0.1) == ("fit_batch",)


def test_an_old_sub_model_of_a_class_defined_again_is_refused(
    cell: Callable[[float | str], Any],
) -> None:
    old = cell(1.0).Cell()
    cell(2.0)
    with pytest.raises(SubModelError, match="make it anew where its class was defined again"):
        made_functions(old, 0.1)


def test_classes_of_cells_that_ran_before_do_not_heap_up(cell: Callable[[float | str], Any]) -> None:
    classes: weakref.WeakSet[type] = weakref.WeakSet()
    for factor in range(200):
        model = cell(factor).Cell()
        classes.add(type(model))
        assert np.array_equal(LOOP.fit(model, WINDOWS), factor * WINDOWS.velocities_mps[:, -1])
    gc.collect()
    assert len(classes) <= 65  # what `made_functions` keeps, and the module's own


def test_an_address_lives_as_long_as_any_array_that_holds_it() -> None:
    model = Coasting()
    functions = model.point_functions(0.1)
    bank = Bank((model,))
    ready = ReadyBank((functions,), bank.windows, bank.offsets, bank.trust)
    for held in (functions.addressed, functions.reading_context(0), ready.members.constants):
        assert held[0] == functions.calls[0].address
    alive = weakref.ref(functions.calls[0].function)
    constants = [functions.addressed, ready.members.constants]
    del functions, ready, held
    for _ in range(2):
        view = constants.pop()[1:]
        gc.collect()
        assert alive() is not None
        del view
    gc.collect()
    assert alive() is None


def test_covariances_whose_rows_change_one_another_are_called_one_by_one() -> None:
    model, parameters = Coasting("spread"), Coasting().fit(WINDOWS)
    with pytest.warns(ModelcastWarning, match="rows of covariance_batch of the sub-model coasting change"):
        together = model.covariance(parameters, HORIZONS_S, dt_s=0.1)
    alone = [model.covariance(one[None], HORIZONS_S, dt_s=0.1)[0] for one in parameters]
    assert np.array_equal(together, alone)


def test_states_whose_rows_change_one_another_are_named() -> None:
    with pytest.warns(
        ModelcastWarning, match="rows of observe_batch and fit_batch of the sub-model smoothed"
    ):
        assert Smoothed(share=np.nan).row_dependence(0.1) == ("observe_batch", "fit_batch")


def test_state_without_a_function_is_refused() -> None:
    @dataclass(frozen=True, slots=True)
    class Unfinished(Coasting):
        state_columns = 1

    with pytest.raises(SubModelError, match="coasting carries state: it needs observe_batch"):
        Unfinished().observed(None, WINDOWS.samples[:, 0], 0.1)


def test_states_of_another_number_of_rows_are_refused() -> None:
    with pytest.raises(ValueError, match=re.escape("states must be (67, S), got (2, 1)")):
        Windows(WINDOWS.samples, dt_s=0.1, states=np.zeros((2, 1)))
