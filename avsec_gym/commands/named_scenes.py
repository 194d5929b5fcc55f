"""The scenes that --scenarios and --kitti name."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from avsec_gym.argument_checks import whole_number
from avsec_gym.errors import ConfigurationError
from avsec_gym.scenario.scene_set import SceneSet

if TYPE_CHECKING:
    from avsec_gym.kitti.dataset import KittiObject


def named_scenes(
    scenarios: str | None,
    kitti: Path | None,
    *,
    seed: int,
    count: int | None = None,
    split: str | None = None,
) -> SceneSet:
    """The set that these options stand for together.

    Args:
        scenarios: A name or a folder, see `scene_set`; None: every labelled frame of `kitti`, or
            ``layouts`` where there is none.
        kitti: Root of the KITTI object data.
        seed: Seed of speeds and layouts.
        count: Number of scenes, the first ones, 1 or more; None: all (200 layouts).
        split: Frames of a split of `kitti`, or of a ``.txt`` file that lists ids, see `split_ids`.

    Raises:
        ConfigurationError: The name is mistyped, a list of ids or a split lacks its KITTI root, a
            split stands beside `scenarios`, or more layouts are asked for than `MOST_LAYOUTS`.
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

    if split is not None and (kitti is None or scenarios is not None):
        raise ConfigurationError(
            "--split takes frames of --kitti ROOT, and stands without --scenarios"
        )
    if count is not None and (scenarios in (LAYOUTS, MIXED_CONTESTED) or not (scenarios or kitti)):
        whole_number("--limit", count, 1, MOST_LAYOUTS)
    if scenarios is not None:
        if kitti is not None and scenarios != KITTI_CONTESTED:
            KittiObject(kitti)  # Refuses a folder of another layout.
        return scene_set(scenarios, kitti=kitti, seed=seed, count=count)
    if kitti is None:
        return scene_set(LAYOUTS, seed=seed, count=count)
    data = KittiObject(kitti)
    return kitti_scenes(data, split_ids(data, split)[:count], seed=seed)


def split_ids(data: KittiObject, split: str | None) -> list[str]:
    """The frames that --split names.

    Args:
        data: The KITTI object data.
        split: A split such as ``val``, of ``ImageSets/val.txt``, or a ``.txt`` file that lists ids;
            None: every labelled frame.

    Raises:
        DataError: There is no such split or file, it is broken, or no frame has a label.
    """
    from avsec_gym.kitti.splits import read_split

    if split is not None and split.endswith(".txt"):
        return read_split(split)
    return data.ids(split, having=() if split else ("label_2",))
