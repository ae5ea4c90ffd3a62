"""The selector: which sub-model of a bank would last longest, by what the window looks like."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Annotated, Any

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.brackets import log_bracket
from modelcast.core.rules import Each, FieldError, Number, One, Text, check_fields
from modelcast.models.address_kernels import FIT_TYPES, point_address
from modelcast.models.base import Windows
from modelcast.models.learned import selector_kernels
from modelcast.models.learned.features import LAGS, FeatureMap
from modelcast.models.learned.learned_trajectory import feature_constants, require_sizes
from modelcast.models.learned.perceptron import Perceptron
from modelcast.models.point_kernels import fit_batch

__all__ = ["Selector"]

THRESHOLD_M = Number(1e-3, 1000.0)
"""A threshold that something was learnt at [m]."""

_LAYERS = ("centre", "width", "weights_1", "bias_1", "weights_2", "bias_2", "weights_3", "bias_3")


@dataclass(frozen=True, slots=True)
class Selector:
    """Predicts, from the window at an update, how long every sub-model of a bank would hold.

    Parameters
    ----------
    members
        Names of the bank's sub-models, in order, (M,).
    thresholds_m
        Thresholds the networks were trained at, rising, (K,) [m].
    networks
        Their mean is taken. The outputs are a score for every threshold and sub-model, threshold by
        threshold, (K·M,); it rises with the expected life.
    lags
        How many tenths of a second the networks look back.
    margin
        Added to the first sub-model's score: another must beat it by more.

    Raises
    ------
    ValueError
        Where a network does not fit the members, the thresholds or the lags, or thresholds do not rise.

    Notes
    -----
    Between the thresholds the last layer is interpolated over the threshold's logarithm; beyond them the
    nearest serves. A window that spans less than ``lags`` tenths of a second has no scores (NaN).
    """

    members: Annotated[tuple[str, ...], Each(Text(64), 1, 8)]
    thresholds_m: Annotated[tuple[float, ...], Each(THRESHOLD_M, 1, 64)]
    networks: Annotated[tuple[Perceptron, ...], Each(One((Perceptron,), "a network"), 1, 16)]
    _: KW_ONLY
    lags: Annotated[int, LAGS] = 20
    margin: Annotated[float, Number(-1e6, 1e6)] = 0.0

    def __post_init__(self) -> None:
        check_fields(self)
        if sorted(set(self.thresholds_m)) != list(self.thresholds_m):
            raise FieldError("thresholds_m", self.thresholds_m, "thresholds that rise")
        outputs = len(self.members) * len(self.thresholds_m)
        require_sizes(self.networks, inputs=FeatureMap(self.lags).inputs, outputs=outputs)

    def window_at(self, dt_s: float) -> int:
        """Samples that span the lags.

        Parameters
        ----------
        dt_s
            Sampling interval [s].
        """
        return FeatureMap(self.lags).window_at(dt_s)

    @property
    def address(self) -> int:
        """The compiled function, with a fit's types, as compiled loops take it in this process."""
        return point_address(selector_kernels.score, FIT_TYPES)

    def check_members(self, names: tuple[str, ...]) -> None:
        """Refuse a bank that is not the one it was trained for.

        Parameters
        ----------
        names
            Names of the bank's sub-models, in order.

        Raises
        ------
        ValueError
            Where they are others.
        """
        if names != self.members:
            raise ValueError(
                f"the selector was trained for {'+'.join(self.members)}, the bank is {'+'.join(names)}"
            )

    def packed(self, dt_s: float, threshold_m: float) -> FloatArray:
        """Feature map and networks as the compiled function reads them, at one threshold.

        Parameters
        ----------
        dt_s
            Sampling interval of the windows [s].
        threshold_m
            The policy's threshold [m].
        """
        at = log_bracket(self.thresholds_m, threshold_m)
        header = feature_constants(FeatureMap(self.lags), dt_s, networks=len(self.networks))
        return np.concatenate([header, *(self._at(network, at).packed() for network in self.networks)])

    def scores(self, windows: Windows, threshold_m: float) -> FloatArray:
        """Scores of the sub-models for every window, (B, M).

        Parameters
        ----------
        windows
            At least `window_at` samples; shorter ones have NaN.
        threshold_m
            The policy's threshold [m].
        """
        out = np.empty((windows.samples.shape[0], len(self.members)))
        samples = np.ascontiguousarray(windows.samples[:, -self.window_at(windows.dt_s) :], dtype=np.float64)
        fit_batch(self.address, samples, self.packed(windows.dt_s, threshold_m), out)
        return out

    def _at(self, network: Perceptron, at: tuple[int, int, float]) -> Perceptron:
        """The network with the outputs of one threshold, between two of those trained."""
        count = len(self.members)
        below, above, share = at
        weights = network.weights_3.reshape(-1, len(self.thresholds_m), count)
        bias = network.bias_3.reshape(-1, count)
        first = np.zeros(count)
        first[0] = self.margin
        return Perceptron(
            network.up_to_noise_m,
            centre=network.centre,
            width=network.width,
            weights_1=network.weights_1,
            bias_1=network.bias_1,
            weights_2=network.weights_2,
            bias_2=network.bias_2,
            weights_3=(1.0 - share) * weights[:, below] + share * weights[:, above],
            bias_3=(1.0 - share) * bias[below] + share * bias[above] + first,
        )

    @property
    def summary(self) -> Mapping[str, Any]:
        """What it was trained for, without its weights."""
        return {
            "members": list(self.members),
            "thresholds_m": list(self.thresholds_m),
            "networks": len(self.networks),
            "margin": self.margin,
        }

    def as_plain(self) -> Mapping[str, Any]:
        """The selector as plain values, for a profile."""
        return {
            "members": list(self.members),
            "thresholds_m": list(self.thresholds_m),
            "lags": self.lags,
            "margin": self.margin,
            "networks": [
                {name: getattr(network, name).tolist() for name in _LAYERS} for network in self.networks
            ],
        }

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Selector":
        """The selector that `as_plain` described.

        Parameters
        ----------
        plain
            Plain values, as read from JSON.
        """
        networks = tuple(
            Perceptron(np.inf, **{name: np.asarray(layers[name], dtype=np.float64) for name in _LAYERS})
            for layers in plain["networks"]
        )
        return cls(
            tuple(str(name) for name in plain["members"]),
            tuple(float(value) for value in plain["thresholds_m"]),
            networks,
            lags=int(plain["lags"]),
            margin=float(plain["margin"]),
        )
