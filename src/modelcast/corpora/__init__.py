"""Whole data sets: recordings as one corpus of Parquet files by vehicle, and jobs over its partitions."""
