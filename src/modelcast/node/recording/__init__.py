"""Recordings of a node: written as it runs, replayed to the bit, shown on the page (docs/recording.md)."""
