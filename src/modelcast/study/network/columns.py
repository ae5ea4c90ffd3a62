"""Columns that several tables of a network evaluation share; definitions are in ``docs/nomenclature.md``."""

from modelcast.study.table import count, quantity, ratio, text

__all__ = [
    "AGE",
    "AIRTIME",
    "BUSY",
    "BYTES",
    "CASE",
    "DELIVERY",
    "GAP",
    "HELD",
    "LOST",
    "MESSAGES",
    "POWER",
    "PTE",
    "SETTING",
    "SPAN",
    "STATE",
    "WARNED",
]

SETTING = (
    quantity("density_per_km", "1/km", "Density asked for; NaN where the scenario has its own."),
    text("radio", "Name of the radio."),
    text("policy", "Name of the policy; of a mixed fleet all of them and the share of the last."),
    text("bank", "Name of the sub-models sent; none where the policy sends none."),
    quantity("threshold_m", "m", "Tracking error that calls for a message; NaN where the policy has none."),
)
"""What is varied, apart from the seed."""

CASE = (*SETTING, count("run", "Number of the seed, from 0."))
"""What is varied."""

SPAN = (
    quantity("low_m", "m", "Lower bound of the distance."),
    quantity("high_m", "m", "Upper bound of the distance."),
)
"""A bin of distance."""

MESSAGES = quantity(
    "message_rate_hz", "1/s", "Messages handed to the radio a vehicle and second.", heading="messages [1/s]"
)
BYTES = quantity("bytes_per_s", "byte/s", "Bytes of frames a vehicle and second.", heading="bytes/s")
AIRTIME = ratio("airtime_ratio", "Share of time that a sender is on the air.")
POWER = quantity("power_dbm", "dBm", "Mean transmit power.", heading="power [dBm]")
BUSY = ratio("busy_ratio", "Mean channel busy ratio.", heading="CBR [%]")
DELIVERY = ratio("delivery_ratio", "Share of pairs of frame and receiver: received.", heading="received [%]")
LOST = {
    "hidden": ratio("hidden_ratio", "Share lost to frames of senders hidden from the sender."),
    "concurrent": ratio("concurrent_ratio", "Share lost to frames that began at the same time."),
    "half_duplex": ratio("half_duplex_ratio", "Share lost because the receiver was sending."),
    "weak": ratio("weak_ratio", "Share too weak by itself."),
}
"""Why frames are lost, by cause."""

HELD = ratio(
    "held_ratio",
    "Share of the samples of pairs in which the host held a live track.",
    heading="tracked [%]",
)
PTE = tuple(
    quantity(f"pte_p{at}_m", "m", f"Tracking error: percentile {at}.", heading=f"PTE p{at} [m]")
    for at in (50, 90, 95, 99)
)
"""Position tracking error."""

AGE = tuple(quantity(f"age_p{at}_s", "s", f"Information age: percentile {at}.") for at in (50, 90))
"""Information age."""

GAP = tuple(
    quantity(f"gap_p{at}_s", "s", f"Inter-packet gap: percentile {at}.", heading=f"IPG p{at} [s]")
    for at in (50, 90)
)
"""Inter-packet gap."""

STATE = (
    quantity("neighbours", "1", "Mean of the smoothed density of J2945/1."),
    quantity("inter_transmit_time_s", "s", "Mean of the longest time between messages by J2945/1."),
    quantity("channel_quality", "1", "Mean of the loss that J2945/1 believes in."),
)
"""State of J2945/1."""

WARNED = (
    text("application", "Name of the application."),
    text("sender", "Whose remotes; all for every sender of a mixed fleet."),
    text("reading", "How hosts read them: legacy, free or model."),
)
"""Of what warnings were."""
