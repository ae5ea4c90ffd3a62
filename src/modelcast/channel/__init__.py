"""What becomes of a transmission."""
