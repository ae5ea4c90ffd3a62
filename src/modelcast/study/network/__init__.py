"""What a network run measured: rows by run, distance and time, their pools over seeds, and the capacity."""
