"""Procedural textures, made from seeds and cached."""
