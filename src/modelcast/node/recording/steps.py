"""Steps and samples as plain values of JSON and back, to the bit."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, cast

import numpy as np

from modelcast.core.rules import Each, Flag, Keys, Maybe, Text, Whole, check
from modelcast.core.rules.scalars import Anything
from modelcast.node.inputs.motion import Motion
from modelcast.node.inputs.samples import GnssFix, Sample
from modelcast.node.node import NodeState
from modelcast.node.recording.plain import ID, TIME, number_of, plain_of, word_of, words_of

__all__ = ["Step", "read_step", "sample_words", "step_words"]

_VALUE = Anything()

_PAIR = Each(_VALUE, 2, 2)

_MOTION = Keys(
    {
        "mode": Text(choices=("gnss+can", "gnss", "can")),
        "place_deg": _PAIR,
        "position_m": _PAIR,
        "speed_mps": _VALUE,
        "heading_rad": _VALUE,
        "acceleration_mps2": _VALUE,
        "yaw_rate_radps": _VALUE,
        "derived": Each(Text(40), 0, 4),
        "covariance_m2": Each(_VALUE, 4, 4),
        "ellipse_known": Flag(),
        "age_s": _VALUE,
        "begins": Flag(),
        "altitude_m": _VALUE,
        "steering_rad": _VALUE,
        "brake": Maybe(Flag()),
    }
)

_STEP = Keys(
    {
        "t_s": TIME,
        "temporary_id": ID,
        "motion": Maybe(_MOTION),
        "warnings": Each(Keys({"application": Text(40), "vehicle": ID, "level": Whole(0, 2)}), 0, 300_000),
    }
)


@dataclass(frozen=True, slots=True)
class Step:
    """One step as it was recorded.

    Parameters
    ----------
    t_s
        Its instant [s].
    motion
        The own motion; None where it was not known.
    temporary_id
        The node's name.
    words
        The whole record, which a replay must say again.
    """

    t_s: float
    motion: Motion | None
    temporary_id: int
    words: dict[str, Any]


def step_words(state: NodeState) -> dict[str, Any]:
    """A step: the own motion, and what is warned of."""
    return {
        "t_s": state.t_s,
        "temporary_id": state.temporary_id,
        "motion": None if state.motion is None else _motion_words(state.motion),
        "warnings": [
            {"application": one.application, "vehicle": one.vehicle, "level": int(one.level)}
            for one in state.warnings
        ],
    }


def read_step(words: object) -> Step:
    """The same back.

    Raises
    ------
    ValueError
        Where it is none.
    """
    check(words, _STEP)
    own = cast("dict[str, Any]", words)
    t_s = float(own["t_s"])
    motion = None if own["motion"] is None else _read_motion(t_s, own["motion"])
    return Step(t_s, motion, own["temporary_id"], own)


def sample_words(now_s: float, samples: Sequence[Sample]) -> dict[str, Any]:
    """Samples as they were taken from their sources at a time."""
    return {
        "now_s": now_s,
        "samples": [
            {"kind": "fix" if isinstance(one, GnssFix) else "bus"}
            | {field.name: plain_of(getattr(one, field.name)) for field in fields(one)}
            for one in samples
        ],
    }


def _motion_words(motion: Motion) -> dict[str, Any]:
    return {
        "mode": motion.mode,
        "place_deg": words_of(motion.place_deg),
        "position_m": words_of(motion.position_m),
        "speed_mps": word_of(motion.speed_mps),
        "heading_rad": word_of(motion.heading_rad),
        "acceleration_mps2": word_of(motion.acceleration_mps2),
        "yaw_rate_radps": word_of(motion.yaw_rate_radps),
        "derived": sorted(motion.derived),
        "covariance_m2": words_of(motion.covariance_m2.reshape(4).tolist()),
        "ellipse_known": bool(motion.ellipse_known),
        "age_s": word_of(motion.age_s),
        "begins": bool(motion.begins),
        "altitude_m": word_of(motion.altitude_m),
        "steering_rad": word_of(motion.steering_rad),
        "brake": motion.brake,
    }


def _read_motion(t_s: float, words: dict[str, Any]) -> Motion:
    def pair(key: str) -> tuple[float, float]:
        first, second = (number_of(value, f"$.motion.{key}") for value in words[key])
        return first, second

    def one(key: str) -> float:
        return number_of(words[key], f"$.motion.{key}")

    covariance = [number_of(value, "$.motion.covariance_m2") for value in words["covariance_m2"]]
    return Motion(
        t_s=t_s,
        mode=words["mode"],
        place_deg=pair("place_deg"),
        position_m=pair("position_m"),
        speed_mps=one("speed_mps"),
        heading_rad=one("heading_rad"),
        acceleration_mps2=one("acceleration_mps2"),
        yaw_rate_radps=one("yaw_rate_radps"),
        derived=frozenset(words["derived"]),
        covariance_m2=np.array(covariance).reshape(2, 2),
        ellipse_known=words["ellipse_known"],
        age_s=one("age_s"),
        begins=words["begins"],
        altitude_m=one("altitude_m"),
        steering_rad=one("steering_rad"),
        brake=words["brake"],
    )
