"""Assets that networks are trained on: of the suites that stand in for data, and of given data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from avsec_gym.world.assets import Assets
from avsec_gym.world.export import cached, read_manifest, suite_recipe

_FRAMES = {"street": 24, "highway": 24, "mixed": 48, "raw": 40}
_DRIVE_FRAMES = 10
"""So that there are four drives, of which every fourth is held out."""


def training_suite(name: str) -> Path:
    """The folder of a small suite of training assets; made in the user's cache on first use.

    Args:
        name: Name of the suite: ``street``, ``highway``, ``mixed``, or ``raw`` (four drives).

    Raises:
        DataError: The cache cannot be written.

    See Also:
        `avsec_gym.world.export.default_suite`: as many frames, of all assets.
    """
    drive_frames = _DRIVE_FRAMES if name == "raw" else None
    recipe = suite_recipe(
        name, _FRAMES[name], previous=0, drive_frames=drive_frames, assets=Assets.TRAIN
    )
    return cached(f"{name}-{Assets.TRAIN}", recipe)


def remark_on_assets(roots: Sequence[Path]) -> str | None:
    """Which data are of assets that detectors are judged on, wholly or in part; None: none are.

    Data of the procedural world state their assets in their manifest; those of its first edition
    do not, since it had no parts.  Data without a manifest, such as KITTI's, are of no assets.

    Args:
        roots: Folders to learn from, or to validate on.

    Raises:
        DataError: A manifest cannot be read.
    """
    others = []
    for root in dict.fromkeys(roots):
        manifest = read_manifest(root)
        if manifest is None:
            continue
        assets = manifest["settings"].get("assets", Assets.ALL)
        if assets != Assets.TRAIN:
            others.append(f"{root} ({assets})")
    if not others:
        return None
    return (
        f"Data with assets that detectors are judged on: {', '.join(others)}. For what learns from"
        " them, frames of judging assets are no test of new cars, houses and trees; `avsec world"
        " make --assets train` makes data without these."
    )
