"""Sensor data validation: is a sensor attacked, which one, and where (thesis, chapters 3 and 4)."""
