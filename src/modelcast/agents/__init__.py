"""The two ends of the air: remote vehicles that send and the host that tracks them."""
