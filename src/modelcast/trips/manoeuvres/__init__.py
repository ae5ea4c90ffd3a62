"""Manoeuvres of a recorded trip: what they are, how they are found, which trip holds the most."""
