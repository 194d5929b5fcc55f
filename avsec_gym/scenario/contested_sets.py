"""Contested scenes by an entry point: to choose them is to drive, which a higher floor does."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Protocol, cast

from avsec_gym.scenario.scene_set import SceneSet

ENTRY_POINT = "avsec_gym.evaluation.contested"
"""The module that chooses contested scenes; nothing of it is imported before it is asked for."""


class ContestedSets(Protocol):
    """What scenes need of that module."""

    def contested(self, scenes: SceneSet) -> SceneSet:
        """The scenes that are contested with some intention, and with which."""

    def contested_layouts(self, scenes: int | None = None, *, seed: int = 0) -> SceneSet:
        """The first procedural scenes that are contested."""

    def contested_frames(self) -> Path:
        """The root of contested scenes with images, in KITTI's object layout."""


def contested_sets() -> ContestedSets:
    """The module that `ENTRY_POINT` names.

    Example:
        >>> [scene.id for scene in contested_sets().contested_layouts(1).scenes]
        ['street-000006']
    """
    return cast(ContestedSets, import_module(ENTRY_POINT))
