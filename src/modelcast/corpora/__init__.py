"""Whole data sets: many recordings as one corpus of Parquet files, partitioned by vehicle."""
