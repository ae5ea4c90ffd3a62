"""Numbers of the applications of IEEE 1609 that safety messages belong to.

References
----------
As Wireshark names them in data of IEEE 1609.2: 32, vehicle to vehicle safety and awareness; 39, vulnerable
road users safety applications.
"""

from typing import Final

__all__ = ["PEOPLE_PSID", "PSIDS", "SAFETY_PSID"]

SAFETY_PSID: Final = 0x20
"""Safety messages of vehicles."""

PEOPLE_PSID: Final = 0x27
"""Safety messages of vulnerable road users."""

PSIDS: Final = (SAFETY_PSID, PEOPLE_PSID)
