"""Compiled rule of the guard: when constant velocity serves because the bank has fallen behind it."""

from modelcast.core.kernel import kernel

__all__ = ["ALLOWED", "falls_back"]

ALLOWED = 2
"""Messages that a sender may have sent more than constant velocity alone before the guard acts."""


@kernel
def falls_back(behind: int, lead: int) -> bool:
    """Whether constant velocity serves.

    ``behind`` is how many messages more than constant velocity alone this sender has sent so far, ``lead``
    how many fewer the bank would have sent without a guard.
    """
    return behind >= ALLOWED and lead < 2.0**behind
