"""Renders the demo's frames by as many processes as the drives beside them leave."""

from __future__ import annotations

from pathlib import Path

from avsec_gym.evaluation.contested import contested_recipe
from avsec_gym.experiments.procedural_frames import CONTESTED, FIRST_SET
from avsec_gym.progress import Progress
from avsec_gym.world.assets import Assets
from avsec_gym.world.export import Sensors, cached


def contested_frames(
    count: int, seed: int, processes: int, on_progress: Progress | None = None
) -> Path:
    """The folder that `procedural_frames` takes for contested scenes, made before it asks for it.

    Args:
        count: The number of frames.
        seed: The demo's seed.
        processes: The number of processes that render; 1 is this very one, which needs no time to
            begin.
        on_progress: Function that gets the number of frames that are done and that of all; without
            it, progress is logged.

    Raises:
        DataError: The cache cannot be written.
    """
    assets = Assets.JUDGE
    recipe = contested_recipe(
        count, seed=FIRST_SET + seed, sensors=Sensors(lidar=False), assets=assets
    )
    return cached(
        f"{CONTESTED}-{assets}-{seed}-{count}", recipe, workers=processes, on_progress=on_progress
    )
