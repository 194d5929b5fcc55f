"""The closed loop: roads, recorded and reacting traffic, a car that drives by its beliefs."""
