"""The work behind chapter 5 on a scene of noise: what is filed, and that it can be done again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from avsec_gym.attacks.patch_files import Patch, PatchCard, save_patch
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter5 import attacked_episodes
from avsec_gym.experiments.chapter5.attacked_cells import attacked_cells, attacked_inputs
from avsec_gym.experiments.chapter5.attacked_episodes import AttackedEpisodes, with_known_motion
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.scenes import scenes_of
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.sensor_files import write_image
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.motion.classifier import MovingObjectClassifier
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import save_weights
from avsec_gym.pipeline import Perception
from avsec_gym.rig import kitti_rig
from avsec_gym.runs.experiment import Configuration
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion
from studies.chapter5.planned_anew import planned_anew

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


def seen_boxes(made: ModuleType) -> Boxes3D:
    """Two that are planned on, one in the way of the car, and between them one that is not."""
    return made.boxes(
        made.car(z=14.0, score=0.9), made.car(x=2.0, z=18.0, score=0.1), made.car(x=3.5, score=0.8)
    )


class _Alternating:
    """A classifier: of the boxes it gets, every other one moves, the first among them."""

    def classify(self, boxes: Boxes3D, frame: SensorFrame) -> Boxes3D:
        return replace(boxes, moving=np.arange(len(boxes)) % 2 == 0)


@pytest.fixture
def classifying(
    configuration: Configuration, made: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> Configuration:
    """A run with ``motion=classifier``, whose detector always sees the same."""
    seen = seen_boxes(made)
    detector = SimpleNamespace(name="dsgn", detect=lambda frame: seen)
    monkeypatch.setattr(attacked_episodes, "trained_detector", lambda name, options: detector)
    return replace(configuration, options={**configuration.options, "motion": "classifier"})


def test_motion_is_that_of_the_packages_classifier(
    classifying: Configuration, made: ModuleType
) -> None:
    (cell,) = attacked_cells(classifying, ("unattacked",), ("dsgn",))
    result = AttackedEpisodes(classifying)(**cell.arguments)
    assert {row.record.intention for row in result.episodes} == set(Intention)
    scenes = scenes_of(classifying)
    seen, (scene,) = seen_boxes(made), scenes.scenes.labelled
    planned_on = seen.score >= 0.3
    frame = scenes.frame(scene)
    expected = MovingObjectClassifier().classify(seen[planned_on], frame).moving
    (row,) = result.detections
    assert row.boxes.moving is not None
    np.testing.assert_array_equal(row.boxes.moving[planned_on], expected)
    assert not row.boxes.moving[~planned_on].any()
    # Nothing but these weights is needed beside what other motions take.
    more = (
        attacked_inputs(classifying).items()
        - attacked_inputs(
            replace(classifying, options={**classifying.options, "motion": "truth"})
        ).items()
    )
    assert [path.name for _, path in more] == ["motion_small.safetensors"]


def test_stored_detections_are_planned_on_anew_as_they_were(
    classifying: Configuration, made: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the classified flags: without them the car in the way, which drives on, would stand."""
    monkeypatch.setattr(attacked_episodes, "CLASSIFIER", _Alternating())
    result = AttackedEpisodes(classifying)("dsgn", "unattacked", ID)
    (row,) = result.detections
    assert row.boxes.moving is not None
    assert row.boxes.moving.tolist() == [True, False, False]
    results, clean, scenes = made.MadeResults(), Condition("dsgn"), scenes_of(classifying)
    results.seen[clean.setting, 0.0] = {ID: row.boxes}
    results.episodes[clean.setting, 0.0, "astar"] = [each.record for each in result.episodes]
    (scene,) = scenes.scenes.labelled
    outcomes = Outcomes(results, {ID: scene.boxes})

    def anew(boxes: Boxes3D) -> list[object]:
        found = planned_anew(
            outcomes,
            scenes,
            Motion.CLASSIFIER,
            [clean],
            {"same": lambda *_: boxes[boxes.score >= 0.3]},
        )
        return [record.to_json() for record in found[clean, "same"]]

    records = sorted((each.record for each in result.episodes), key=lambda one: one.intention)
    stored = [record.to_json() for record in records]
    assert anew(row.boxes) == stored
    assert anew(replace(row.boxes, moving=np.zeros(3, bool))) != stored


def test_flags_of_what_is_planned_on_are_kept(made: ModuleType) -> None:
    seen = seen_boxes(made)
    believed = replace(seen[[0, 2]], moving=np.array([False, True]))
    found = with_known_motion(Perception(seen, believed, None), 0.3)
    assert found.moving is not None
    assert found.moving.tolist() == [False, False, True]
    assert with_known_motion(Perception(seen, seen[[0, 2]], None), 0.3) is seen


def test_a_mistyped_motion_is_refused_before_the_work(configuration: Configuration) -> None:
    slip = replace(configuration, options={**configuration.options, "motion": "clasifier"})
    with pytest.raises(ConfigurationError, match="no motion 'clasifier'"):
        attacked_inputs(slip)


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


@pytest.mark.slow
def test_the_ghost_that_is_measured_is_as_wide_as_in_the_training(
    configuration: Configuration, tmp_path: Path
) -> None:
    losses = {}
    for width in (None, 0.5, 1.63):
        folder = tmp_path / str(width)
        folder.mkdir()
        card = PatchCard(training={"ghost_width": width})
        save_patch(folder / "stereo_rcnn.safetensors", replace(Patch.grey(), card=card))
        options = {**configuration.options, "patches": str(folder)}
        result = AttackedEpisodes(replace(configuration, options=options))(
            "stereo_rcnn", "patch-random", ID
        )
        found = {row.name: row.value for row in result.measurements}
        assert found["change"] > 0
        losses[width] = found["clean_ghost_loss"]
    # The same place and the same clean frame: only the ghost differs.
    assert len(set(losses.values())) == 3
