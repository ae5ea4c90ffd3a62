"""The step protocol: another simulator's vehicles as stations, over a socket of this machine."""
