"""Kinds of the parts of a radio, by the words that name them: path loss, error model and others."""

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Any

from modelcast.channel.dsrc_parameters import ACCESS_CATEGORIES, AccessCategory
from modelcast.channel.erasure import GilbertElliott, Ideal, IndependentErasure
from modelcast.channel.error_models import (
    AbstractErrorModel,
    NistErrorModel,
    TabulatedErrorModel,
    ThresholdErrorModel,
)
from modelcast.channel.path_loss import DualSlope, LogDistance, ManhattanNlos, Tr37885, TwoRay, WinnerB1
from modelcast.channel.propagation import NakagamiFading, Propagation, Shadowing
from modelcast.channel.radio import AbstractRadio
from modelcast.channel.radio_settings import Family, Kind, RadioForm
from modelcast.channel.table_error_model import TableErrorModel
from modelcast.core.exceptions import ConfigError

__all__ = ["ERROR_MODELS", "PATH_LOSSES", "radio_form"]


def _always(make: Callable[[], Any]) -> Callable[[Any], Any]:
    """What makes a part whatever the parameters are."""
    return lambda _parameters: make()


def _slopes(make: Callable[[], DualSlope]) -> Kind:
    """Two slopes; their own shadowing is told in a docstring and set by the key of shadowing."""
    return Kind(_always(make), hidden=("shadowing_db",))


PATH_LOSSES: Mapping[str, Kind] = {
    "winner-b1": Kind(_always(WinnerB1)),
    "log-distance": Kind(_always(LogDistance)),
    "two-ray": Kind(_always(TwoRay)),
    "dual-slope": _slopes(DualSlope.highway_los),
    "dual-slope-urban": _slopes(DualSlope.urban_los),
    "dual-slope-obstructed": _slopes(DualSlope.urban_obstructed),
    "tr37885": Kind(_always(Tr37885.highway)),
    "tr37885-urban": Kind(_always(Tr37885.urban)),
    "tr37885-nlos": Kind(_always(Tr37885.nlos)),
}
"""Path losses of `modelcast.channel.path_loss`."""

_SHADOWING: Mapping[str, Kind] = {
    "log-normal": Kind(_always(Shadowing), called={"los_db": "shadowing_db", "nlos_db": "shadowing_nlos_db"}),
    "none": Kind(_always(lambda: None)),
}
_FADING: Mapping[str, Kind] = {
    "nakagami": Kind(
        _always(NakagamiFading),
        called={
            "shapes.0": "fading_near_shape",
            "shapes.1": "fading_middle_shape",
            "shapes.2": "fading_far_shape",
            "edges_m.0": "fading_near_m",
            "edges_m.1": "fading_far_m",
        },
    ),
    "none": Kind(_always(lambda: None)),
}
_LOSS = {"loss_db": "implementation_loss_db"}


def _nist(parameters: Any) -> NistErrorModel:
    return NistErrorModel(parameters.bit_rate.bits_per_subcarrier, parameters.bit_rate.code_rate)


_RATED_MODELS: Mapping[str, Kind] = {
    "nist": Kind(_nist, called=_LOSS, hidden=("bits_per_symbol", "code_rate")),
    "table": Kind(
        lambda parameters: TableErrorModel(parameters.rate_mbps), called=_LOSS, hidden=("rate_mbps",)
    ),
}
"""Error models that follow the bit rate of a radio's parameters."""

ERROR_MODELS: Mapping[str, Kind] = {
    "threshold": Kind(_always(lambda: ThresholdErrorModel(0.0)), needed=("threshold_db",)),
    "highway-los": Kind(_always(TabulatedErrorModel.highway_los)),
    "highway-nlos": Kind(_always(TabulatedErrorModel.highway_nlos)),
    "urban-los": Kind(_always(TabulatedErrorModel.urban_los)),
    "crossing-nlos": Kind(_always(TabulatedErrorModel.crossing_nlos)),
    "sidelink-mcs5": Kind(_always(TabulatedErrorModel.sidelink_mcs5)),
    "nr-mcs7": Kind(_always(TabulatedErrorModel.nr_mcs7)),
    "nr-mcs21": Kind(_always(TabulatedErrorModel.nr_mcs21)),
}
"""Error models that any radio of frames can have."""

_ACCESS: Mapping[str, Kind] = {
    name.replace(" ", "-"): Kind(_always(lambda category=category: category))
    for name, category in ACCESS_CATEGORIES.items()
}
_CHANNELS: Mapping[str, Kind] = {
    "ideal": Kind(_always(Ideal)),
    "independent": Kind(_always(lambda: IndependentErasure(0.0)), needed=("ratio",)),
    "bursts": Kind(_always(lambda: GilbertElliott(0.0)), needed=("ratio",)),
}


def _family(selector: str, kinds: Mapping[str, Kind], held: Any, parameters: Any = None) -> Family:
    """A family whose default is the kind that is held already."""
    default = next((name for name, kind in kinds.items() if kind.base(parameters) == held), None)
    return Family(selector, kinds, default, held, parameters)


def _placed(radio: Any, changes: Mapping[str, Any], propagation: Propagation | None) -> Any:
    """The radio with these changes, in its own propagation or that given: fading as its error model asks."""
    held: Propagation | None = getattr(radio, "propagation", None)
    if held is None:
        changed = replace(radio, **changes)
        return changed if propagation is None else changed.within(propagation)
    bare = replace(radio, **changes, propagation=replace(held, fading=None))
    return bare.within(held if propagation is None else propagation)


def _with_path_loss(before: Propagation, after: Propagation) -> Propagation:
    """The loss round a corner goes with that along the first street, and so does that of raised antennas.

    Raises
    ------
    ConfigError
        Where antennas are raised and the path loss does not know the heights of both ends.
    """
    path_loss = after.path_loss
    if path_loss == before.path_loss:
        return after
    if isinstance(after.nlos, ManhattanNlos):
        after = replace(after, nlos=replace(after.nlos, los=path_loss))
    if after.raised is None:
        return after
    high = after.raised.path_loss
    if not (isinstance(high, WinnerB1 | TwoRay) and isinstance(path_loss, WinnerB1 | TwoRay)):
        raise ConfigError(
            "antennas are raised (as roadside units' are), so path_loss must be winner-b1 or two-ray: the "
            "others do not know the heights of both ends"
        )
    over_road = replace(path_loss, other_antenna_m=high.other_antenna_m)
    return replace(after, raised=replace(after.raised, path_loss=over_road))


def radio_form(radio: AbstractRadio[Any]) -> RadioForm:
    """Keys of a radio, found by what its fields are.

    Parameters
    ----------
    radio
        A dataclass, with its defaults. What it holds in ``parameters``, ``propagation`` and
        ``error_model`` is reached; arrays and tables are not.
    """
    families: dict[tuple[str, str], Family] = {}
    parameters = getattr(radio, "parameters", None)
    for one in fields(parameters) if parameters is not None else ():
        if isinstance(held := getattr(parameters, one.name), AccessCategory):
            families["parameters", one.name] = _family(one.name, _ACCESS, held)
    for one in fields(radio):  # pyright: ignore[reportArgumentType] - radios of ours are dataclasses
        held = getattr(radio, one.name)
        if isinstance(held, Propagation):
            for name, kinds in (("path_loss", PATH_LOSSES), ("shadowing", _SHADOWING), ("fading", _FADING)):
                families[one.name, name] = _family(name, kinds, getattr(held, name))
        elif isinstance(held, Ideal):
            families[one.name, ""] = _family(one.name, _CHANNELS, held)
        elif one.name == "error_model":
            families[one.name, ""] = _error_family(held, parameters)
    return RadioForm(radio, families, _placed, {"propagation": _with_path_loss})


def _error_family(held: AbstractErrorModel | None, parameters: Any) -> Family:
    """Error models of a radio; where it holds none, it takes that of its bit rate, or its ``own``."""
    if hasattr(parameters, "bit_rate"):
        kinds = {**_RATED_MODELS, **ERROR_MODELS}
        held = _nist(parameters) if held is None else held
    else:
        kinds = {"own": Kind(_always(lambda: None)), **ERROR_MODELS} if held is None else ERROR_MODELS
    return _family("error_model", kinds, held, parameters)
