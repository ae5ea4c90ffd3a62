"""What a station makes of what it hears."""
