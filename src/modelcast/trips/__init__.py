"""One vehicle's recorded trip: what it is, whether it can be true, what may be made of it."""
