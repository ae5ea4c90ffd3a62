"""ns-3's IEEE 802.11p as a radio of modelcast: ns-3 carries what modelcast's stations send."""

from ns3_radio.program import build, installed_ns3
from ns3_radio.radio import Ns3Radio

__all__ = ["Ns3Radio", "build", "installed_ns3"]
