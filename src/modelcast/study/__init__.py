"""Rates, tracking under loss, and the walk of a policy over a recorded trip."""
