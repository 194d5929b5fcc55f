"""The work behind chapter 5 on a scene of noise: what is filed, and that it can be done again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter5.attacked_episodes import (
    AttackedEpisodes,
    attacked_cells,
    attacked_inputs,
)
from avsec_gym.kitti.sensor_files import write_image
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import save_weights
from avsec_gym.rig import kitti_rig
from avsec_gym.runs.experiment import Configuration
from avsec_gym.scenario.intention import Intention

ID = "000003"
LABEL = "Car 0.00 0 -1.57 600.00 170.00 650.00 210.00 1.50 1.60 4.00 0.00 1.65 20.00 -1.57\n"


@pytest.fixture(scope="module")
def configuration(tmp_path_factory: pytest.TempPathFactory) -> Configuration:
    """One frame of noise with a label, and weights as they come."""
    root = tmp_path_factory.mktemp("data")
    folder = root / "training"
    for name in ("label_2", "calib", "image_2", "image_3"):
        (folder / name).mkdir(parents=True)
    (folder / "label_2" / f"{ID}.txt").write_text(LABEL)
    rows = [" ".join(map(str, row.ravel())) for row in kitti_rig().calibration.projections]
    eye, velodyne = "1 0 0 0 1 0 0 0 1", "0 -1 0 0 0 0 -1 0 1 0 0 0"
    lines = [*(f"P{n}: {row}" for n, row in enumerate(rows)), f"R0_rect: {eye}"]
    lines += [f"Tr_velo_to_cam: {velodyne}", f"Tr_imu_to_velo: {velodyne}"]
    (folder / "calib" / f"{ID}.txt").write_text("\n".join(lines) + "\n")
    random = np.random.default_rng(0)
    for camera in (2, 3):
        noise = random.integers(0, 256, (96, 320, 3), np.uint8)
        write_image(folder / f"image_{camera}" / f"{ID}.png", noise)
    weights = root / "weights.safetensors"
    save_weights(weights, StereoRcnnDetector().network, ModelCard("stereo_rcnn"))
    options = {"stereo_rcnn": str(weights), "dsgn": str(weights)}
    return Configuration(str(root), options=options)


def test_cells_and_inputs_name_what_results_depend_on(configuration: Configuration) -> None:
    cells = attacked_cells(configuration, ("unattacked", "thesis_pgd-1"))
    assert [cell.arguments["attack"] for cell in cells] == ["unattacked", "thesis_pgd-1"] * 2
    assert {cell.arguments["scenario"] for cell in cells} == {ID}
    assert {cell.group for cell in cells} == {ID}
    assert "weights of stereo_rcnn" in attacked_inputs(configuration)


def test_a_grey_disc_is_seen_by_all_intentions_or_by_each_its_own(
    configuration: Configuration,
) -> None:
    work = AttackedEpisodes(configuration)
    by_chance = work("stereo_rcnn", "grey-random", ID)
    assert [row.setting for row in by_chance.detections] == ["stereo_rcnn grey-random"]
    assert {row.record.intention for row in by_chance.episodes} == set(Intention)
    aimed = work("stereo_rcnn", "grey-specific", ID)
    assert [row.setting for row in aimed.detections] == [
        f"stereo_rcnn grey-specific-{intention}" for intention in Intention
    ]
    aims = {row.setting: row.value for row in aimed.measurements if row.name == "attack_intention"}
    assert list(aims.values()) == [0, 1, 2]
    again = AttackedEpisodes(configuration)("stereo_rcnn", "grey-specific", ID)
    assert [row.record.to_json() for row in again.episodes] == [
        row.record.to_json() for row in aimed.episodes
    ]
    assert [row.value for row in again.measurements] == [row.value for row in aimed.measurements]


@pytest.mark.slow
def test_every_step_of_a_perturbation_within_its_budget(configuration: Configuration) -> None:
    result = AttackedEpisodes(configuration)("stereo_rcnn", "thesis_pgd-0.4", ID)
    filed = [(row.setting, row.strength) for row in result.detections]
    assert filed == [
        (f"stereo_rcnn thesis_pgd-0.4{rounded}", n)
        for n in (1, 2, 3, 4)
        for rounded in ("", " 8-bit")
    ]
    assert len(result.episodes) == 3 * len(filed)
    (change,) = [row.value for row in result.measurements if row.name == "change"]
    assert change == pytest.approx(4 * 0.4, abs=1e-4)


@pytest.mark.slow
def test_without_the_sanity_sheet_there_are_neither_losses_nor_rounded_pixels(
    configuration: Configuration,
) -> None:
    options = {**configuration.options, "sanity_sheet": False}
    work = AttackedEpisodes(replace(configuration, options=options))
    patched = work("stereo_rcnn", "grey-random", ID)
    assert {row.name for row in patched.measurements} == {
        "change",
        "attack_intention",
        "ghost_seen",
    }
    perturbed = work("stereo_rcnn", "thesis_pgd-1", ID)
    assert [(row.setting, row.strength) for row in perturbed.detections] == [
        ("stereo_rcnn thesis_pgd-1", n) for n in (1, 2, 3, 4)
    ]
    assert [row.name for row in perturbed.measurements] == ["change"]


def test_unknown_attacks_are_refused(configuration: Configuration) -> None:
    with pytest.raises(ConfigurationError, match="no attack 'laser'"):
        AttackedEpisodes(configuration)("stereo_rcnn", "laser", ID)


@pytest.mark.slow
def test_a_stronger_attack_is_filed_by_its_steps(configuration: Configuration) -> None:
    options = {**configuration.options, "steps": [1, 2], "eot_copies": 2}
    work = AttackedEpisodes(replace(configuration, options=options))
    result = work("stereo_rcnn", "eot_pgd-4", ID)
    assert [(row.setting, row.strength) for row in result.detections] == [
        ("stereo_rcnn eot_pgd-4", 1), ("stereo_rcnn eot_pgd-4", 2)
    ]  # fmt: skip
    assert len(result.episodes) == 2 * len(Intention)
    changes = {row.strength: row.value for row in result.measurements if row.name == "change"}
    assert changes == {1: pytest.approx(1.0, abs=1e-4), 2: pytest.approx(2.0, abs=1e-4)}
    again = work.again("stereo_rcnn", "eot_pgd-4", ID, Intention.LEFT, 2)
    assert again.episode.record == result.episodes[3].record
