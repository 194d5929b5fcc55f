"""Frames of the procedural world for one experiment: as many as it takes, from a seed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from avsec_gym.errors import ConfigurationError
from avsec_gym.evaluation.contested import contested_recipe
from avsec_gym.storage.regular_files import is_there
from avsec_gym.unknown_source import unknown_source
from avsec_gym.world.assets import Assets
from avsec_gym.world.export import Sensors, cached, suite_recipe

PROCEDURAL = "procedural"
"""What these scenarios are called."""
CONTESTED = "procedural_contested"
"""The first of them that are contested: in which it matters what a car sees."""
USUAL_COUNT = 12

FIRST_SET = 1000
"""The package's networks were trained and chosen on sets of layouts with small seeds."""
_ASSETS = Assets.JUDGE


def check_place(scenarios: str, suites: Sequence[str] = ()) -> None:
    """Check that scenarios are somewhere: `PROCEDURAL`, of a default suite, or in a folder.

    Args:
        scenarios: The place as named by who runs an experiment.
        suites: Names that the experiment knows beside `PROCEDURAL`.

    Raises:
        ConfigurationError: It is a mistyped name.
        DataError: It is a folder that is not there.
    """
    names = (PROCEDURAL, *suites)
    if scenarios not in names and not is_there(Path(scenarios)):
        raise unknown_source(scenarios, names, f"Name a folder, or {' or '.join(names)}.")


def procedural_frames(count: int | None = None, seed: int = 0, *, contested: bool = False) -> Path:
    """Stereo pairs of streets and highways in KITTI's object layout, with labels, without LiDAR.

    All that is shown is made of judging assets: cars that none of the package's networks was
    trained on.  Houses, plants and textures are new as well to those that did not begin on the
    world's first edition, which was not divided.

    Made in the user's cache on first use, by two processes, while the log states how long it takes,
    and kept there; looked at, and made anew if a file is damaged, whenever they are asked for.

    Args:
        count: The number of frames; `USUAL_COUNT` if None.
        seed: Other seeds are other scenes, all of them new to the package's networks.
        contested: Whether only contested scenes are taken, see `avsec_gym.evaluation.contested`.

    Returns:
        Their folder.

    Raises:
        ConfigurationError: There cannot be so many, or the seed is below 0.
        DataError: The cache cannot be written.

    Example:
        >>> procedural_frames(3, seed=7)  # doctest: +SKIP
        PosixPath('/home/me/.cache/avsec-gym/suites/procedural-judge-7-3-5f1c0b7d6a9e4c32')
    """
    if seed < 0:
        raise ConfigurationError(f"a seed is 0 or more, got {seed}")
    count = USUAL_COUNT if count is None else count
    sensors = Sensors(lidar=False)
    if contested:
        chosen = contested_recipe(count, seed=FIRST_SET + seed, sensors=sensors, assets=_ASSETS)
        return cached(f"{CONTESTED}-{_ASSETS}-{seed}-{count}", chosen)
    recipe = suite_recipe("mixed", count, FIRST_SET + seed, sensors=sensors, assets=_ASSETS)
    return cached(f"{PROCEDURAL}-{_ASSETS}-{seed}-{count}", recipe)
