"""What the package ships, for validation without clean frames: made, and judged."""
