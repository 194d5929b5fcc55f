"""Traffic over time."""
