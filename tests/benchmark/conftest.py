"""A benchmark of two scenes with small images, and quick parts in place of the networks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from avsec_gym.benchmark import (
    entry_sets,
    episodes,
    frames,
    loop_drives,
    loop_protocol,
    making,
    protocol,
)
from avsec_gym.benchmark.loop_scenes import FrozenDrives, digest_of_drives, frozen_drives
from avsec_gym.benchmark.scene_sets import Extent, FrozenSet, digest_of, frozen_sets
from avsec_gym.evaluation.contested import chosen_recipe
from avsec_gym.rig import camera_rig
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_sets import scene_of_layout
from avsec_gym.world.export import Sensors
from avsec_gym.world.layouts import generate_layout

RIG = camera_rig([-0.2, 0.3, 0.0, 0.5], focal_length=200.0, centre=(160.0, 60.0), size=(320, 120))
SEED = frozen_sets()["contested"].seed


def frozen(name: str, numbers: tuple[int, ...], ways: Mapping[int, frozenset[Intention]] | None):
    """A set of few scenes of the frozen ones."""
    scenes = (generate_layout(number, set_seed=SEED) for number in numbers)
    digest = digest_of(scene_of_layout(layout, SEED) for layout in scenes)
    extent = Extent(len(numbers), len(numbers))
    return FrozenSet(name, SEED, numbers, ways, extent, Extent(1, 1), digest)


def few_drives(ways: Mapping[str, tuple[Intention, ...]], quick: int = 1) -> FrozenDrives:
    """A set of few drives of the frozen ones, and one error model for planners."""
    models = dict([*frozen_drives().error_models.items()][:1])
    made = FrozenDrives(frozen_drives().seed, ways, quick, "", "", models)
    digests = (
        digest_of_drives(map(made.scenes.scene, made.ids(quick=quick))) for quick in (False, True)
    )
    return FrozenDrives(made.seed, ways, quick, *digests, models)


@pytest.fixture(scope="session")
def small_cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch, small_cache: Path) -> dict[str, FrozenSet]:
    """The benchmark's sets are these, and the parts that entries meet are quick."""
    contested = frozen_sets()["contested"]
    first = contested.numbers[0]
    assert contested.intentions is not None
    sets = {
        "all": frozen("all", (0, 1), None),
        "contested": frozen("contested", (first,), {first: contested.intentions[first]}),
    }
    for module in (making, entry_sets, episodes, frames):
        monkeypatch.setattr(module, "frozen_sets", lambda: sets)
    first, second = [*frozen_drives().ways][:2]
    drives = few_drives({id: frozen_drives().ways[id] for id in (first, second)})
    for module in (entry_sets, loop_drives, loop_protocol):
        monkeypatch.setattr(module, "frozen_drives", lambda: drives)
    sensors = Sensors((2, 3), rig=RIG)
    monkeypatch.setattr(
        "avsec_gym.benchmark.scene_sets.chosen_recipe",
        lambda numbers, **given: chosen_recipe(numbers, sensors=sensors, **given),
    )
    for module in (protocol, loop_protocol):
        monkeypatch.setattr(module, "DETECTORS", ("oracle", "scan_obstacles"))
    for name in ("PERTURBATION", "STRONGER"):
        monkeypatch.setattr(protocol, name, {"name": "random_noise", "strength": 8.0})
    monkeypatch.setattr(protocol, "QUIETER", {})
    monkeypatch.setattr(
        protocol, "OPTICAL", {"facula": ("oracle", {"name": "facula", "camera": 2})}
    )
    # Textures are drawn once, wherever the user's cache is.
    from avsec_gym.world.textures.library import cache_folder, texture_library

    texture_library()
    for path in cache_folder().glob("textures-*"):
        if not (small_cache / path.name).exists():
            (small_cache / path.name).symlink_to(path)
    monkeypatch.setenv("AVSEC_CACHE", str(small_cache))
    return sets
