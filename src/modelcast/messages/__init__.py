"""What a transmission holds, and how large it is."""
