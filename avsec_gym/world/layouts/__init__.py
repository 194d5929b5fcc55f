"""Seeded KITTI-like object layouts: the embedded default data, for users without KITTI."""

from avsec_gym.world.layouts.layout import (
    MOST_LAYOUTS,
    SceneLayout,
    generate_layout,
    generate_layouts,
    layout_by_id,
)

__all__ = ["MOST_LAYOUTS", "SceneLayout", "generate_layout", "generate_layouts", "layout_by_id"]
