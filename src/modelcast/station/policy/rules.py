"""Names of what the algorithm leaves open: the one list that policy, settings and command line share."""

from typing import Literal

__all__ = ["BelieveRule", "CostUnit", "IdentifyRule", "StartRule"]

BelieveRule = Literal["sent", "expected"]
"""What a sender takes its remotes to hold, as `modelcast.station.policy.error_driven.ErrorDriven` has it."""

CostUnit = Literal["messages", "bytes", "airtime"]
"""What the rule ``cheapest`` counts."""

StartRule = Literal["order", "keep", "survivor", "predicted", "hindsight", "guarded", "recent"]
"""Sub-model in use after an update, as `modelcast.station.policy.error_driven.ErrorDriven` describes them."""

IdentifyRule = Literal["on-failure", "final", "best", "never", "cheapest"]
"""When another sub-model is named."""
