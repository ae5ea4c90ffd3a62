"""What the devices of people of a run did, as a table."""

from dataclasses import replace

from modelcast.study.network.columns import AIRTIME, CASE, MESSAGES, POWER
from modelcast.study.table import TableSchema, quantity, ratio, text

__all__ = ["PEOPLE"]

PEOPLE = TableSchema(
    "people",
    "What the devices of the people of one run sent and received; the policy is the vehicles'.",
    (
        *CASE,
        text("people_policy", "What people send by."),
        quantity("people", "1", "How many there were, on average.", heading="people"),
        replace(MESSAGES, description="Messages a device and second.", heading="sent [1/s]"),
        ratio("certificate_ratio", "Share of these with a certificate."),
        quantity("frame_bytes", "byte", "Mean bytes of a frame sent.", heading="frame [B]"),
        AIRTIME,
        POWER,
        quantity(
            "received_rate_hz",
            "1/s",
            "Messages that the radio of a device decoded.",
            heading="received [1/s]",
        ),
        quantity(
            "unread_rate_hz",
            "1/s",
            "Of these, those of whom the device keeps no map.",
            heading="unread [1/s]",
        ),
        quantity(
            "far_rate_hz",
            "1/s",
            "Of the others, those that state a place beyond reach.",
            heading="too far [1/s]",
        ),
        quantity(
            "read_rate_hz",
            "1/s",
            "What is left: those whose signatures are checked, and that are tracked.",
            heading="read [1/s]",
        ),
    ),
)
"""Devices of people: a row a run."""
