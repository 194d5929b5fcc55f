"""Textures: walls and all that is in them and above them."""

from __future__ import annotations

from avsec_gym.world.textures import facades, masonry, roofing
from avsec_gym.world.textures.texture import Texture

TEXTURES: dict[str, Texture] = {
    "stucco": Texture((5.0, 5.0), 4, masonry.stucco),
    "stucco_foot": Texture((5.0, 1.0), 4, masonry.stucco_foot),
    "brick": Texture((4.0, 4.0), 5, masonry.brick),
    "sandstone": Texture((4.8, 4.8), 4, masonry.sandstone),
    "rubble": Texture((2.0, 2.0), 3, masonry.rubble),
    "concrete": Texture((4.8, 4.8), 3, masonry.concrete),
    "wall_tile": Texture((4.2, 4.2), 2, masonry.wall_tile),
    "timber": Texture((2.0, 4.0), 2, masonry.timber),
    "glass_blocks": Texture((1.0, 1.0), 3, masonry.glass_blocks),
    "roof_tile": Texture((3.6, 4.08), 4, roofing.roof_tile),
    "slate": Texture((3.0, 3.2), 3, roofing.slate),
    "sheet_metal": Texture((2.0, 4.0), 3, roofing.sheet_metal),
    "cladding": Texture((2.0, 4.0), 3, roofing.cladding),
    "window_pane": Texture((1.0, 1.0), 8, facades.window_pane),
    "shop_window": Texture((1.0, 1.0), 5, facades.shop_window),
    "door": Texture((1.0, 1.0), 6, facades.door),
    "garage_door": Texture((1.0, 1.0), 4, facades.garage_door),
    "shutter": Texture((1.0, 1.0), 3, facades.shutter),
    "awning": Texture((1.6, 1.6), 2, facades.awning),
    "shop_sign": Texture((1.0, 1.0), 13, facades.shop_sign),
}
