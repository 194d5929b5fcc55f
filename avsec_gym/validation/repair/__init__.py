"""Where a named sensor is damaged, and its data repaired by the sound sensors."""
