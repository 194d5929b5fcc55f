"""The cells of chapter 5, and the files that they need: scenes, detectors and attacks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from avsec_gym.experiments.chapter5.scene_draw import drawn_scenes
from avsec_gym.experiments.chapter5.scenes import OPTIONS, scenes_of
from avsec_gym.experiments.chapter5.settings import DETECTORS
from avsec_gym.experiments.chapter5.stronger_attacks import (
    STRONGER_OPTIONS,
    chosen_attacks,
    looked_at_steps,
)
from avsec_gym.experiments.chapter5.trained import trained_inputs
from avsec_gym.perception.weights.given import shipped_weights
from avsec_gym.runs.experiment import Cell, Configuration
from avsec_gym.scenario.scene import Motion

_WORK = "avsec_gym.experiments.chapter5.attacked_episodes:AttackedEpisodes"


def attacked_cells(
    configuration: Configuration,
    attacks: Sequence[str],
    detectors: Sequence[str] = DETECTORS,
) -> list[Cell]:
    """A cell for every scene, detector and attack, scene by scene."""
    return [
        Cell.of(_WORK, scene.id, detector=detector, attack=attack, scenario=scene.id)
        for scene in scenes_of(configuration).scenes.scenes
        for detector in detectors
        for attack in attacks
    ]


def stronger_cells(
    configuration: Configuration, detectors: Sequence[str] = DETECTORS
) -> list[Cell]:
    """A cell for every drawn scene, detector and stronger attack that the options name.

    Raises:
        ConfigurationError: There is no such attack, or no such draw or number of steps.
    """
    options = {**STRONGER_OPTIONS, **configuration.options}
    attacks = chosen_attacks(options)
    looked_at_steps(options)  # A slip is reported before anything is done.
    ids = [scene.id for scene in scenes_of(configuration).scenes.labelled]
    drawn = set(drawn_scenes(ids, options["drawn_scenes"], configuration.seed))
    return [
        cell
        for cell in attacked_cells(configuration, attacks, detectors)
        if cell.arguments["scenario"] in drawn
    ]


def attacked_inputs(
    configuration: Configuration, detectors: Sequence[str] = DETECTORS
) -> dict[str, Path]:
    """Weights, patches and the images' manifests.

    Raises:
        ConfigurationError: There is no such motion, or weights are needed that are not named.
        DataError: Weights are missing, or those of another network.
    """
    options = {**OPTIONS, **configuration.options}
    trained = trained_inputs(detectors, options)
    if Motion.named(options["motion"]) == Motion.CLASSIFIER:
        trained["weights of the moving-object classifier"] = shipped_weights("motion_small")
    roots = {data.root for data in scenes_of(configuration).data.values()}
    manifests = {
        f"frames {number}": root / "manifest.json"
        for number, root in enumerate(sorted(roots), start=1)
        if (root / "manifest.json").is_file()
    }
    return {**trained, **manifests}
