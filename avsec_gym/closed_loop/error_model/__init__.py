"""What a detector gets wrong, drawn instead of computed: misses, displaced boxes, ghosts."""
