"""Which cells the experiments ask for, and which they share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from avsec_gym.attacks.patch_files import Patch, save_patch
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter5 import (
    attacked_cells,
    attacked_episodes,
    patch_spreads,
    true_episodes,
)
from avsec_gym.experiments.chapter5.stronger_attacks import STRONGER_NAMES
from avsec_gym.runs.catalogue import EXPERIMENTS, experiment
from avsec_gym.runs.experiment import Cell, Configuration, with_defaults
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_set import SceneSet

WITHOUT = "dsgn_without_pyramid"


@pytest.fixture(autouse=True)
def two_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    scenes = tuple(Scene(name, Boxes3D.empty()) for name in ("000000", "000001"))
    frames = FrameScenes(SceneSet("two", scenes), {})
    for module in (attacked_cells, attacked_episodes, patch_spreads, true_episodes):
        monkeypatch.setattr(module, "scenes_of", lambda configuration: frames)


def cells(name: str, **options: Any) -> list[Cell]:
    asked = experiment(name)
    return list(asked.cells(with_defaults(Configuration(options=options), [asked])))


def test_every_name_in_the_catalogue_is_that_of_its_experiment() -> None:
    assert [experiment(name).name for name in EXPERIMENTS] == list(EXPERIMENTS)


def test_the_chapter_holds_what_its_parts_ask_for(tmp_path: Path) -> None:
    folder = str(tmp_path)
    whole = set(cells("chapter5", patches=folder))
    parts = {"demo"} | {name for name, place in EXPERIMENTS.items() if ".chapter5." in place}
    for name in parts - {"without_pyramid", "stronger_perturbations"}:
        assert set(cells(name, patches=folder)) <= whole, name
    texture, ghosts = set(cells("texture")), set(cells("ghost_positions"))
    assert texture < ghosts


def test_stronger_attacks_are_done_where_they_are_asked_for(tmp_path: Path) -> None:
    folder = str(tmp_path)
    usual = set(cells("chapter5", patches=folder))
    every = cells("stronger_perturbations", drawn_scenes=1)
    assert {cell.group for cell in every} == {"000000"}  # The one that is drawn.
    attacks = [cell.arguments["attack"] for cell in every]
    assert set(attacks) == {"unattacked", *STRONGER_NAMES}
    assert len(attacks) == 2 * len(set(attacks))  # For each detector.
    named = {"stronger": "bounded_class_pgd-4, class_pgd-1", "drawn_scenes": 1}
    two = set(cells("stronger_perturbations", **named))
    assert {cell.arguments["attack"] for cell in two} == {
        "unattacked", "class_pgd-1", "bounded_class_pgd-4"
    }  # fmt: skip
    more = set(cells("chapter5", patches=folder, **named))
    assert more == usual | two > usual
    # A larger draw holds a smaller one: a run's results stay good.
    assert set(every) < set(cells("stronger_perturbations", drawn_scenes=2))


def test_slips_in_the_options_of_stronger_attacks_are_reported_before_the_work() -> None:
    for wrong, words in (
        ({"stronger": "bounded"}, "no stronger 'bounded'"),
        ({"drawn_scenes": 0}, "drawn_scenes takes"),
        ({"steps": []}, "steps takes one"),
        ({"steps": [4, 0]}, "steps takes a whole number"),
    ):
        with pytest.raises(ConfigurationError, match=words):
            cells("stronger_perturbations", **wrong)


def test_dsgn_without_its_pyramid_needs_weights_and_takes_patches_that_both_have(
    tmp_path: Path,
) -> None:
    assert cells("without_pyramid") == []
    with pytest.raises(ConfigurationError, match=f"--options {WITHOUT}=FILE"):
        experiment("without_pyramid").inputs(Configuration(options={"dsgn": __file__}))
    for name in ("dsgn", "joint"):
        save_patch(tmp_path / f"{name}.safetensors", Patch.grey())
    options = {"patches": str(tmp_path), WITHOUT: "somewhere"}
    found = [cell.arguments for cell in cells("without_pyramid", **options)]
    episodes = {
        (arguments["detector"], arguments["attack"]) for arguments in found if "attack" in arguments
    }
    attacks = ("unattacked", "joint-random", "joint-specific")
    assert episodes == {(name, attack) for name in ("dsgn", WITHOUT) for attack in attacks}
    assert {arguments["detector"] for arguments in found if "images" in arguments} == {
        "dsgn",
        WITHOUT,
    }
