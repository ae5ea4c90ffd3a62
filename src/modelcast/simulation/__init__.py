"""Traffic that is made, not recorded."""
