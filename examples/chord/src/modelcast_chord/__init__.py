"""A sub-model for modelcast in plain NumPy."""

from modelcast_chord.chord import Chord

__all__ = ["Chord"]
