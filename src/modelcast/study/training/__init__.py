"""Training: what all vehicles share, learned from windows of many trips."""
