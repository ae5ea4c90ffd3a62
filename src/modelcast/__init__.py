"""Model-based communication for V2X: see the README and ``docs/``."""
