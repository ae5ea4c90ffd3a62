"""Platoons in line: leaders that drive a profile of speed, followers that are told how to accelerate."""
