"""When to transmit what."""
