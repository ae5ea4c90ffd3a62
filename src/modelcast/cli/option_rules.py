"""What every option of ``modelcast evaluate`` may be: for the command line, and for a ``run.json``.

Both are held against the same table, so that a run which was accepted can be repeated.
"""

from typing import Any, get_args

from modelcast.core.rules import AbstractRule, Each, Flag, Keys, Maybe, Number, Text, Whole
from modelcast.messages.rules import CertificateRule
from modelcast.station.policy.rules import BelieveRule, CostUnit, IdentifyRule, StartRule
from modelcast.station.sensing.rules import VelocityRule
from modelcast.world.named_sensors import SENSORS

__all__ = ["LONGEST_PATH", "OPTIONS"]

LONGEST_PATH = 1024
"""Characters of a path that a run may be repeated with: what every system takes."""

_HOUR_S, _DAY_S = 3600.0, 86_400.0
_NOISE = Number(0.0, 1000.0)


def _word(choices: Any) -> Text:
    return Text(choices=get_args(choices))


_RULES: dict[str, AbstractRule] = {
    "threshold": Each(Number(0.0, 1000.0, over=True), 1, 64),
    "per": Each(Number(0.0, 1.0), 0, 64),
    "seeds": Whole(1, 10_000),
    "seed": Whole(0, 2**64),
    "bank": Text(500),
    "profile": Maybe(Text(LONGEST_PATH)),
    "window": Whole(1, 1000),
    "noise_floor": Maybe(_NOISE),
    "trusted_horizon": Number(0.0, _HOUR_S),
    "start": Maybe(_word(StartRule)),
    "identify": Maybe(_word(IdentifyRule)),
    "cost": _word(CostUnit),
    "policy": Maybe(Text(400)),
    "keep_alive": Number(0.0, _DAY_S),
    "burst": Number(0.0, _HOUR_S),
    "delay": Number(0.0, _HOUR_S),
    "expiry": Number(0.0, _DAY_S),
    "protocol": Text(choices=("auto", "recorded", "sensor")),
    "samples": Text(choices=("first", "all", "none")),
    "references": Flag(),
    "map": Maybe(Text(1000)),
    "quantised": Flag(),
    "certificates": _word(CertificateRule),
    "position_noise": Maybe(_NOISE),
    "slow_noise": Maybe(_NOISE),
    "speed_noise": Maybe(_NOISE),
    "heading_noise": Maybe(Number(0.0, 360.0)),
    "latency": Maybe(Number(0.0, _HOUR_S)),
    "shared_bias": Maybe(Number(0.0, 1.0)),
}

OPTIONS = Keys(
    _RULES,
    {
        "sensor": Maybe(Text(choices=tuple(SENSORS))),
        "velocity": _word(VelocityRule),
        "road": Text(LONGEST_PATH),
        "leader": Flag(),
        "believe": Maybe(_word(BelieveRule)),
        "budget": Number(0.0, 1000.0, over=True),
        "legacy_threshold": Number(0.0, 1000.0),
        "rates_only": Flag(),
        "detail": Maybe(Number(0.0, 1000.0, over=True)),
    },
)
"""Of all options by name, as `modelcast.cli.evaluate_options.EvaluateOptions.as_plain` writes them.

Runs from before sensors had names, or velocities, context, beliefs, legacy thresholds, rates alone or
details, do not say which; theirs is the default.
"""
