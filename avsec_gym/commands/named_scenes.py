"""The scenes that --scenarios and --kitti name."""

from __future__ import annotations

from pathlib import Path

from avsec_gym.argument_checks import whole_number
from avsec_gym.scenario.scene_set import SceneSet


def named_scenes(
    scenarios: str | None, kitti: Path | None, *, seed: int, count: int | None = None
) -> SceneSet:
    """The set that both options stand for together.

    Args:
        scenarios: A name or a folder, see `scene_set`; None: every labelled frame of `kitti`, or
            ``layouts`` where there is none.
        kitti: Root of the KITTI object data.
        seed: Seed of speeds and layouts.
        count: Number of scenes, the first ones, 1 or more; None: all (200 layouts).

    Raises:
        ConfigurationError: The name is mistyped, a list of ids lacks its KITTI root, or more
            layouts are asked for than `MOST_LAYOUTS`.
        DataError: A folder or file is missing or broken.
    """
    from avsec_gym.kitti.dataset import KittiObject
    from avsec_gym.scenario.scene_sets import (
        KITTI_CONTESTED,
        LAYOUTS,
        MIXED_CONTESTED,
        kitti_scenes,
        scene_set,
    )
    from avsec_gym.world.layouts import MOST_LAYOUTS

    if count is not None and (scenarios in (LAYOUTS, MIXED_CONTESTED) or not (scenarios or kitti)):
        whole_number("--limit", count, 1, MOST_LAYOUTS)
    if scenarios is not None:
        if kitti is not None and scenarios != KITTI_CONTESTED:
            KittiObject(kitti)  # Refuses a folder of another layout.
        return scene_set(scenarios, kitti=kitti, seed=seed, count=count)
    if kitti is None:
        return scene_set(LAYOUTS, seed=seed, count=count)
    data = KittiObject(kitti)
    return kitti_scenes(data, data.ids(having=("label_2",))[:count], seed=seed)
