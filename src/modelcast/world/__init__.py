"""What is outside a station: traffic, roads, and the sensors through which it sees itself."""
