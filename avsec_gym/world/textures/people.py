"""Textures: people."""

from __future__ import annotations

from avsec_gym.world.textures.texture import Texture

TEXTURES: dict[str, Texture] = {}
