"""Words of a safety evaluation that command lines and settings share; importing them costs nothing."""

from typing import Literal, get_args

__all__ = ["BASES", "Basis", "Truth"]

Basis = Literal["threshold", "messages", "airtime"]
"""What rivals have in common: the threshold, the messages sent, or their time on the air."""

Truth = Literal["knowledge", "communication"]
"""What is held to be right: what hosts would do that knew how both vehicles truly move, or that heard every
sample of the sender at once, as its sensors show it."""

BASES: tuple[Basis, ...] = get_args(Basis)
