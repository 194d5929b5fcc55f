"""The default suites: made in the user's cache on first use, and looked at whenever opened."""

from __future__ import annotations

import logging
import shutil
import time
from pathlib import Path

from avsec_gym.errors import ConfigurationError
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.raw import KittiRaw
from avsec_gym.progress import Progress
from avsec_gym.storage.folder_lock import folder_lock
from avsec_gym.storage.folders import make_folder
from avsec_gym.world.export.connected_world import ConnectedWorld
from avsec_gym.world.export.data_set import make_data_set
from avsec_gym.world.export.manifest import changed_files, read_manifest, world_fingerprint
from avsec_gym.world.export.recipe import Recipe
from avsec_gym.world.export.suites import SUITES, suite_recipe
from avsec_gym.world.textures.library import cache_folder

DEFAULT_FRAMES = {"street": 24, "highway": 24, "mixed": 48, "connected": 6, "raw": 40}
"""How many frames the default suites have; the raw one in two drives."""

_DRIVE_FRAMES = 20
_LOG = logging.getLogger(__name__)


def default_suite(
    name: str,
    *,
    workers: int | None = None,
    full_check: bool = False,
    on_progress: Progress | None = None,
) -> Path:
    """The folder of a default suite; made if it is not there, anew if a file is damaged.

    Other processes that want the same suite wait until it is there.

    Args:
        name: Name of the suite, one of `SUITES`.
        workers: Number of processes, as of `make_data_set`.
        full_check: Whether every file is read instead of its size compared.
        on_progress: Function of the progress, as of `make_data_set`; without it, progress is
            logged.

    Raises:
        ConfigurationError: An unknown suite.
        DataError: The cache cannot be written.

    See Also:
        `world_frames`, `world_instants`, `world_drives`: its readers.
    """
    if name not in SUITES:
        raise ConfigurationError(f"{name!r} is no suite; there are {', '.join(SUITES)}")
    frames = _DRIVE_FRAMES if name == "raw" else None
    recipe = suite_recipe(name, DEFAULT_FRAMES[name], previous=0, drive_frames=frames)
    return cached(name, recipe, workers, full_check, on_progress)


def cached(
    name: str,
    recipe: Recipe,
    workers: int | None = None,
    full_check: bool = False,
    on_progress: Progress | None = None,
) -> Path:
    """The folder of a data set in the cache; see `default_suite`."""
    suites = cache_folder() / "suites"
    make_folder(suites)
    root = suites / f"{name}-{world_fingerprint()}"
    if _is_sound(root, full_check):
        return root
    with folder_lock(suites, wait=True, what=f"the default suite {name}"):
        if _is_sound(root, full_check):  # Another process has made it meanwhile.
            return root
        if (manifest := read_manifest(root)) is not None and manifest["complete"]:
            _LOG.warning("the data set in %s is damaged and is made anew", root)
            shutil.rmtree(root)
        _LOG.warning("making the default suite %s, once: %d frames", name, len(recipe))
        make_data_set(recipe, root, workers=workers, on_progress=on_progress or _logged(name))
    return root


def world_frames(name: str = "mixed", *, vehicle: int | None = None) -> KittiObject:
    """A default suite of single frames, through the reader of the real benchmark.

    Args:
        name: ``street``, ``highway``, ``mixed``, or ``connected``.
        vehicle: Number of the vehicle of ``connected``, from 0.

    Raises:
        ConfigurationError: Another name, or a vehicle that is not there.

    Example:
        >>> data = world_frames("mixed")  # doctest: +SKIP
        >>> data.frame("000000").image(2).shape  # doctest: +SKIP
        (375, 1242, 3)
    """
    if name == "raw" or (name == "connected") != (vehicle is not None):
        raise ConfigurationError(
            "single frames are those of 'street', 'highway' and 'mixed', and of one vehicle of "
            f"'connected', such as vehicle=0; got {name!r} and vehicle={vehicle}"
        )
    root = default_suite(name)
    if vehicle is None:
        return KittiObject(root)
    if not (root / f"vehicle_{vehicle}").is_dir():
        raise ConfigurationError(f"there is no vehicle {vehicle} in the suite 'connected'")
    return KittiObject(root / f"vehicle_{vehicle}")


def world_instants() -> ConnectedWorld:
    """The default suite of connected vehicles: instants, all views, and the truth of all."""
    return ConnectedWorld(default_suite("connected"))


def world_drives() -> KittiRaw:
    """The default suite of drives, through the reader of real ones."""
    return KittiRaw(default_suite("raw"))


def _is_sound(root: Path, full: bool) -> bool:
    manifest = read_manifest(root)
    if manifest is None or not manifest["complete"]:
        return False
    return not changed_files(root, full=full)


def _logged(name: str) -> Progress:
    begun = said = time.monotonic()

    def tell(done: int, total: int) -> None:
        nonlocal said
        now = time.monotonic()
        if now - said > 10.0:
            said = now
            left = (now - begun) / done * (total - done)
            _LOG.warning("%s: %d of %d frames, about %.0f s left", name, done, total, left)

    return tell
