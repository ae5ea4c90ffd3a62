"""What the devices of people of a run did, as rows."""

from dataclasses import dataclass

__all__ = ["PeopleRow"]


@dataclass(frozen=True, slots=True, kw_only=True)
class PeopleRow:
    """What the devices of the people of one run sent and received, each in a second.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run
        As in `modelcast.study.network.rows.NetworkCase`: the policy is the vehicles'.
    people_policy
        What people send by.
    people
        How many there were, on average.
    message_rate_hz
        Messages sent.
    certificate_ratio
        Share of these with a certificate.
    frame_bytes
        Of a frame sent, on average [B].
    airtime_ratio
        Share of the time that a device sends, 0..1.
    power_dbm
        Mean transmit power [dBm].
    received_rate_hz
        Messages that the radio decoded.
    unread_rate_hz
        Of these, those of whom the device keeps no map.
    far_rate_hz
        Of the others, those that state a place beyond reach.
    read_rate_hz
        What is left: those whose signatures are checked, and that are tracked.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    people_policy: str
    people: float
    message_rate_hz: float
    certificate_ratio: float
    frame_bytes: float
    airtime_ratio: float
    power_dbm: float
    received_rate_hz: float
    unread_rate_hz: float
    far_rate_hz: float
    read_rate_hz: float
