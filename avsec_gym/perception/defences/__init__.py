"""Defences of the image: what happens to a picture before a detector sees it."""
