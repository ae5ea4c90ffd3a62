"""Claims about the words that name and set a radio."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.dsrc_parameters import BIT_RATES, DsrcParameters
from modelcast.channel.error_models import NistErrorModel, ThresholdErrorModel
from modelcast.channel.path_loss import (
    AbstractPathLoss,
    DualSlope,
    LogDistance,
    ManhattanNlos,
    TwoRay,
    WinnerB1,
)
from modelcast.channel.propagation import NakagamiFading, Propagation, RaisedAntennas, Shadowing, StreetGrid
from modelcast.channel.radio import Transmissions
from modelcast.channel.radio_parts import radio_form
from modelcast.channel.radio_presets import PRESETS
from modelcast.channel.radio_words import get_radio, radio_keys
from modelcast.channel.registry import RADIOS
from modelcast.channel.sidelink_parameters import wilab_sidelink_parameters
from modelcast.channel.table_error_model import TableErrorModel
from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import ConfigError, ModelcastWarning

OWN = tuple(RADIOS.own)
every_radio = pytest.mark.parametrize("name", OWN)


class _Flat(AbstractPathLoss):
    """A path loss that has no name."""

    def loss_db(self, distance_m: FloatArray) -> FloatArray:
        """The same anywhere, any shape [dB]."""
        return np.full_like(distance_m, 80.0)


def refusal(word: str) -> str:
    with pytest.raises(ConfigError) as refused:
        get_radio(word)
    return str(refused.value)


@every_radio
def test_a_bare_name_is_the_radio_with_its_defaults(name: str) -> None:
    plain = get_radio(name)
    assert type(plain) is type(RADIOS.made(name))
    if name == "dsrc":
        assert plain == Dsrc()


@every_radio
def test_each_key_is_listed_once(name: str) -> None:
    keys = [one.key for one in radio_keys(name)]
    assert len(keys) == len(set(keys))


@every_radio
def test_every_field_of_the_parameters_has_a_key(name: str) -> None:
    parameters: Any = getattr(RADIOS.made(name), "parameters", None)
    if parameters is not None:
        assert {one.name for one in fields(parameters)} <= set(radio_form(RADIOS.made(name)).keys())


@pytest.mark.slow
@every_radio
def test_setting_a_default_changes_nothing(name: str) -> None:
    for one in radio_keys(name):
        if one.default in {"needed", "the radio's own"} or one.goes_with or one.key == "preset":
            continue
        same = get_radio(f"{name}:{one.key}={one.default}")
        assert getattr(same, "parameters", None) == getattr(get_radio(name), "parameters", None)
        assert getattr(same, "propagation", None) == getattr(get_radio(name), "propagation", None)


@settings(max_examples=15)
@given(st.floats(0.0, 20.0), st.floats(-100.0, -60.0), st.floats(1.5, 4.0))
def test_settings_arrive_in_parameters_propagation_and_error_model(
    figure_db: float, sensitivity_dbm: float, exponent: float
) -> None:
    word = (
        f"dsrc:noise_figure_db={figure_db!r},sensitivity_dbm={sensitivity_dbm!r},path_loss=log-distance,"
        f"exponent={exponent!r},error_model=table,rate_mbps=12,shadowing=none,fading_far_shape=2,aifsn=3"
    )
    radio = get_radio(word)
    assert isinstance(radio, Dsrc)
    expected = DsrcParameters(12.0, noise_figure_db=figure_db, sensitivity_dbm=sensitivity_dbm)
    assert radio.parameters == replace(expected, access=replace(expected.access, aifsn=3))
    fading = NakagamiFading((3.0, 1.5, 2.0))
    assert radio.propagation == Propagation(LogDistance(exponent), None, fading)
    assert radio.error_model == TableErrorModel(12.0)


def test_error_models_follow_the_bit_rate() -> None:
    found = get_radio("dsrc:rate_mbps=12,implementation_loss_db=5")
    assert isinstance(found, Dsrc)
    assert found.error_model == NistErrorModel(4, 0.5, loss_db=5.0)


@pytest.mark.parametrize("rate_mbps", sorted(BIT_RATES))
def test_every_bit_rate_can_be_set_whatever_tables_there_are(rate_mbps: float) -> None:
    found = get_radio(f"dsrc:rate_mbps={rate_mbps:g}")
    assert found == Dsrc(DsrcParameters(rate_mbps))


def test_settings_change_the_part_that_is_held_and_leave_the_rest_of_it() -> None:
    near = Propagation(LogDistance(2.2, 50.0), None)
    found = get_radio("dsrc:exponent=2.5", near)
    assert isinstance(found, Dsrc)
    assert found.propagation == replace(near, path_loss=LogDistance(2.5, 50.0))
    fitted = replace(DualSlope.urban_los(), break_m=80.0)
    found = get_radio("dsrc:far_exponent=3", Propagation(fitted))
    assert isinstance(found, Dsrc)
    assert found.propagation.path_loss == replace(fitted, far_exponent=3.0)


@pytest.mark.parametrize("held", [DualSlope.highway_los(), _Flat()])
def test_a_key_that_the_held_part_has_not_is_refused(held: AbstractPathLoss) -> None:
    with pytest.raises(ConfigError, match="antenna_m goes with path_loss=winner-b1 or two-ray"):
        get_radio("dsrc:antenna_m=2", Propagation(held))


def test_a_key_of_one_kind_alone_names_it() -> None:
    found = get_radio("dsrc:threshold_db=6.5")
    assert isinstance(found, Dsrc)
    assert found.error_model == ThresholdErrorModel(6.5)
    found = get_radio("dsrc:antenna_m=1.8")
    assert isinstance(found, Dsrc)
    assert found.propagation.path_loss == WinnerB1(antenna_m=1.8)


def test_a_radio_without_powers_takes_its_own_settings() -> None:
    assert get_radio("ideal:channel=independent,ratio=0.1,range_m=300") != get_radio("ideal:range_m=300")
    assert "goes with channel=independent or bursts" in refusal("ideal:ratio=0.1")


def test_settings_change_the_propagation_of_a_town_and_leave_its_streets() -> None:
    town = Propagation(
        shadowing=Shadowing(decorrelation_m=10.0), streets=StreetGrid(200.0), nlos=ManhattanNlos()
    )
    found = get_radio("dsrc:path_loss=two-ray,shadowing_db=5", town)
    assert isinstance(found, Dsrc)
    assert found.propagation == replace(
        town, path_loss=TwoRay(), shadowing=Shadowing(5.0, decorrelation_m=10.0), nlos=ManhattanNlos(TwoRay())
    )
    assert get_radio("dsrc:noise_figure_db=6", town) == get_radio("dsrc", town)


@pytest.mark.parametrize(
    ("word", "path_loss"),
    [
        ("dsrc:frequency_ghz=5.8", WinnerB1(5.8)),
        ("sidelink:path_loss=two-ray,antenna_m=1.6", TwoRay(5.9, 1.6)),
    ],
)
def test_links_of_roadside_units_have_the_path_loss_that_is_set(
    word: str, path_loss: WinnerB1 | TwoRay
) -> None:
    units = RaisedAntennas(2, WinnerB1(other_antenna_m=6.0), 4.0)
    found: Any = get_radio(word, Propagation(raised=units))
    assert found.propagation.path_loss == path_loss
    assert found.propagation.raised == replace(units, path_loss=replace(path_loss, other_antenna_m=6.0))


def test_a_path_loss_without_heights_is_refused_beside_roadside_units() -> None:
    raised = Propagation(raised=RaisedAntennas(1, WinnerB1(other_antenna_m=6.0)))
    with pytest.raises(ConfigError, match="path_loss must be winner-b1 or two-ray"):
        get_radio("dsrc:preset=ns3-default", raised)


@pytest.mark.parametrize("name", ["dsrc", "sidelink", "nr"])
@pytest.mark.parametrize("errors", ["threshold,threshold_db=8", "highway-los"])
def test_fading_goes_where_the_error_model_of_the_word_asks(name: str, errors: str) -> None:
    """As `within` of the same radio made by hand; nobody is warned."""
    radio: Any = get_radio(f"{name}:error_model={errors}", Propagation())
    assert radio.propagation.fading == (None if errors == "highway-los" else NakagamiFading())
    assert radio == get_radio(f"{name}:error_model={errors}").within(Propagation())
    with pytest.warns(ModelcastWarning, match="lost to it twice"):
        again: Any = get_radio(f"{name}:error_model=highway-los,fading=nakagami", Propagation())
    assert again.propagation.fading == NakagamiFading()


PRESET_WORDS = [(name, preset) for name, presets in PRESETS.items() for preset in presets]


@pytest.mark.parametrize(("name", "preset"), PRESET_WORDS)
def test_a_preset_is_its_settings_written_out(name: str, preset: str) -> None:
    settings = PRESETS[name][preset].settings
    written = ",".join(f"{key}={str(value).lower()}" for key, value in settings.items())
    assert get_radio(f"{name}:preset={preset}") == get_radio(f"{name}:{written}")
    assert get_radio(f"{name}:preset={preset}") != get_radio(name)


def test_settings_change_a_preset_whatever_their_order() -> None:
    first = get_radio("dsrc:preset=wilab,capture_db=3")
    assert get_radio("dsrc:capture_db=3,preset=wilab") == first
    assert isinstance(first, Dsrc)
    assert (first.parameters.capture_db, first.parameters.preamble_db) == (3.0, 6.5)


def test_another_kind_of_a_part_leaves_the_presets_settings_of_it() -> None:
    found = get_radio("dsrc:preset=ns3-default,path_loss=winner-b1,error_model=nist")
    assert isinstance(found, Dsrc)
    assert found.propagation == Propagation(WinnerB1(), None, None)
    assert found.error_model == NistErrorModel()
    assert found.parameters.energy_dbm == -82.0


def test_naming_the_kind_that_a_preset_has_changes_nothing() -> None:
    for name, preset in PRESET_WORDS:
        found = get_radio(f"{name}:preset={preset}")
        for family in radio_form(RADIOS.made(name)).families.values():
            meant = family.chosen(PRESETS[name][preset].settings, family.default)
            assert get_radio(f"{name}:preset={preset},{family.selector}={meant}") == found
    shadowing = get_radio("dsrc:preset=deployed-obu,shadowing=log-normal").propagation.shadowing  # type: ignore[attr-defined]
    assert shadowing == Shadowing(3.95)


@pytest.mark.parametrize(
    ("word", "told"),
    [
        (
            "dsrc:noise_figure=3",
            "no setting 'noise_figure' (is noise_figure_db meant?). Settings: access, aifs_on_arrival,",
        ),
        ("dsrc:zzz=3", "there is no setting 'zzz'. Settings: access"),
        ("dsrc:noise_figure_db=loud", "noise_figure_db must be a number, got loud"),
        ("dsrc:noise_figure_db=nan", "noise_figure_db must be a number, got nan"),
        ("dsrc:noise_figure_db=true", "noise_figure_db must be a number, got yes"),
        ("dsrc:immediate_access=1", "immediate_access must be yes or no, got 1"),
        ("dsrc:bins=2.5", "bins must be a whole number, got 2.5"),
        ("dsrc:rate_mbps=5", "rate_mbps must be one of"),
        ("dsrc:rate_mbps=4.5,error_model=table", "there are tables of"),
        ("dsrc:error_model=tabel", "got tabel (is table meant?)"),
        ("dsrc:error_model=threshold", "error_model=threshold needs threshold_db"),
        ("dsrc:path_loss=winner-b1,exponent=3", "exponent goes with path_loss=log-distance"),
        ("dsrc:antenna_m=0.5", "effective_height_m must be positive"),
        ("dsrc:preset=wilub", "no preset 'wilub' (is wilab meant?): it has ns3-default"),
        ("ideal:preset=wilab", "no preset 'wilab': it has none"),
        ("sidelink:error_model=nist", "error_model must be threshold,"),
        ("dsrc:rate_mbps=6,rate_mbps=3", "sets rate_mbps twice"),
        ("dsrc:noise_figure_db=1e6", "noise_figure_db must lie within -300..300, got 1000000.0"),
        ("dsrc:antenna_gain_db=-301", "antenna_gain_db must lie within -300..300"),
        ("dsrc:max_power_dbm=1e5", "max_power_dbm must lie within -300..300"),
        ("dsrc:margin_db=-50", "margin_db must not be negative, got -50"),
        ("dsrc:bins=100001", "bins must lie within 1..100000, got 100001"),
        ("dsrc:bins=0", "bins must lie within 1..100000, got 0"),
        ("dsrc:bin_m=1e-9", "bin_m must be finite and at least 0.1, got 1e-09"),
        ("dsrc:window=100000000000000000000", "window must be a whole number within 64 bits, got 1000"),
        ("dsrc:window=32768", "window 32767, got"),
        ("dsrc:aifsn=16", "aifsn must be at most 15"),
        ("dsrc:slot_s=1e300", "slot_s must lie within 0..10 s"),
        ("dsrc:busy_window_s=1e-300", "busy_window_s must be at least 0.001 s, got 1e-300"),
        ("dsrc:bandwidth_hz=1e-300", "bandwidth_hz must lie within"),
        ("nr:sensitivity_dbm=1e5", "The radio 'nr' refuses its settings"),
        ("sidelink:noise_figure_db=1e6", "The radio 'sidelink' refuses its settings"),
        ("sidelink:control_blocks=-9223372036854775808", "within 64 bits"),
        ("ideal:range_m=1" + 400 * "0", "range_m must be a number within 64 bits"),
        ("abstract:rate_mbps=1e300", "rate_mbps must be positive, at most 1e+06, got 1e+300"),
        ("abstract:symbol_s=1e300", "symbol_s must be positive, at most 1, got 1e+300"),
        ("abstract:preamble_s=1e300", "preamble_s must not be negative, at most 1,"),
        ("abstract:load_dbm=-1e6", "load_dbm must lie within -300..300"),
        ("abstract:antenna_gain_db=1e6", "antenna_gain_db must lie within -300..300"),
    ],
)
def test_what_does_not_go_is_told(word: str, told: str) -> None:
    assert told in refusal(word)


def test_loss_and_luck_of_a_set_radio_are_those_of_the_same_radio_made_by_hand() -> None:
    """A word and a constructor give one radio: one seed, the same receptions."""
    by_word = get_radio("dsrc:path_loss=two-ray,error_model=table,antenna_gain_db=3")
    by_hand = Dsrc(DsrcParameters(antenna_gain_db=3.0), Propagation(TwoRay()), TableErrorModel())
    assert by_word == by_hand
    rng = np.random.default_rng(5)
    position_m = np.column_stack([rng.uniform(0.0, 2000.0, 40), np.zeros(40)])
    one = Transmissions(
        np.arange(40),
        np.sort(rng.uniform(0.0, 0.1, 40)),
        size_bytes=np.full(40, 300),
        power_dbm=np.full(40, 20.0),
        message_id=np.arange(40),
    )
    found = [
        radio.step(radio.init(40, np.random.default_rng(2)), one, position_m, 0.2)[0]
        for radio in (by_word, by_hand)
    ]
    assert found[0].size > 500
    assert found[0].t_s.tolist() == found[1].t_s.tolist()
    assert found[0].outcomes.tolist() == found[1].outcomes.tolist()


def test_the_preset_of_mode_4_is_the_set_of_parameters() -> None:
    assert get_radio("sidelink:preset=wilab").parameters == wilab_sidelink_parameters()  # type: ignore[attr-defined]
