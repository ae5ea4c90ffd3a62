"""Platoons in a closed loop: what followers hear drives them, and what they drive is what is said next."""
