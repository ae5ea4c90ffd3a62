"""Stations for another simulator, which moves the vehicles and carries the messages; no sockets in here."""
