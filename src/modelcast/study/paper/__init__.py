"""The paper's evaluation on any trips: its settings, what it leaves open, and what then holds."""
