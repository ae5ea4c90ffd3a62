"""What version 0.1.0 called otherwise, for the error of whoever asks for it by its old name.

``docs/upgrading.md`` has the whole map.
"""

from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["RENAMED"]

RENAMED: Mapping[str, str] = MappingProxyType(
    {
        "agents": "modelcast.station.receiver",
        "evaluation": "modelcast.study",
        "policy": "modelcast.station.policy",
        "simulation": "modelcast.world and modelcast.runtime.fleet",
    }
)
"""Sub-packages of 0.1.0 that are gone, and what took their place."""
