"""Training: what all vehicles share, learnt from recorded trips."""
