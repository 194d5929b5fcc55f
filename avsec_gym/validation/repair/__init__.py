"""Where a named sensor is damaged, and what the sound ones make of it."""
