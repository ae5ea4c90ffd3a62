"""Whole data sets: recordings as one corpus of Parquet files, partitioned by vehicle, and jobs over it."""
