"""What drives stations: recorded trips, and fleets on a shared channel."""
