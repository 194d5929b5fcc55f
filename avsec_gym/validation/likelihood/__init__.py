"""The sensor state vector from all evidence at once, and a probability for each sensor."""
