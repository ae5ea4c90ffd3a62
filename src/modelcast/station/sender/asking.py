"""Asks a policy in NumPy about some stations, keeps its state, and checks what it decides."""

from typing import Any

import numpy as np

from modelcast.core.arrays import IntArray
from modelcast.core.exceptions import PolicyError
from modelcast.station.policy.base import AbstractTransmitPolicy, Air, Decisions, Motion, TransmitInputs
from modelcast.station.policy.state_rows import check_state, put_rows, take_rows
from modelcast.station.sender.deciding_kernels import Asked

__all__ = ["Asking", "inputs_of"]


class Asking:
    """A policy and its state for the stations that it decides for.

    Parameters
    ----------
    policy
        The policy.
    vehicles, sub_models
        How many of each.
    rng
        Of the policy alone: the same numbers give the same messages.

    Raises
    ------
    ValueError
        Where the policy's state has no row a vehicle.
    """

    def __init__(
        self,
        policy: AbstractTransmitPolicy[Any],
        vehicles: int,
        sub_models: int,
        rng: np.random.Generator,
    ) -> None:
        self._policy, self._sub_models, self._rng = policy, sub_models, rng
        self._name = type(policy).__name__
        self._state: Any = policy.init(vehicles, sub_models)
        check_state(self._state, vehicles, self._name)

    def begin(self, rows: IntArray) -> None:
        """Let some stations have sent nothing.

        Parameters
        ----------
        rows
            Which, (B,).
        """
        if rows.size:
            fresh = self._policy.init(rows.size, self._sub_models)
            self._state = put_rows(self._state, rows, fresh, self._name)

    def decide(self, rows: IntArray, inputs: TransmitInputs) -> Decisions:
        """Ask about some stations.

        Parameters
        ----------
        rows
            Which, (B,).
        inputs
            What they know.

        Raises
        ------
        PolicyError
            Where it decides what a station cannot do, or its state becomes one that the state of
            `init` cannot hold; it names the policy.
        """
        try:
            said, after = self._policy.decide(take_rows(self._state, rows), inputs, self._rng)
            said.check(inputs)
        except ValueError as error:
            raise PolicyError(f"{self._name}: {error}") from error
        check_state(after, rows.size, self._name)
        self._state = put_rows(self._state, rows, after, self._name)
        return said


def inputs_of(asked: Asked, rows: IntArray, *, dt_s: float, critical: Any, air: Air) -> TransmitInputs:
    """What some stations know, as policies take it.

    Parameters
    ----------
    asked
        Of all stations.
    rows
        Which, (B,).
    dt_s
        How long the interval lasts that is decided on [s].
    critical
        Whether a critical event goes on, (B,).
    air
        What these stations know of the channel.
    """
    return TransmitInputs(
        asked.ask_s[rows],
        asked.age_s[rows],
        silence_s=asked.silence_s[rows],
        tracking_error_m=asked.error_m[rows],
        available=asked.available[rows],
        in_use=asked.in_use[rows],
        until_s=asked.ask_s[rows] + dt_s,
        motion=Motion(
            asked.position_m[rows],
            asked.speed_mps[rows],
            heading_rad=asked.heading_rad[rows],
            critical=critical,
        ),
        air=air,
    )
