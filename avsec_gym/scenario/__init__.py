"""Planning scenarios: intentions, driving constraints, scenes, sets of them, CommonRoad files."""
