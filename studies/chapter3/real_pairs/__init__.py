"""All real pairs of images at hand: clean, and with small and faint lights in one of them."""
