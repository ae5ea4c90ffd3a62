"""Whole data sets: corpora of trips in partitions, and jobs over them on all cores or on a cluster."""
