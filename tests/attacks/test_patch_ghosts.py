"""Ghosts of a given width, near and far, and how a training passes them on to what it made."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import Polygon, box

from avsec_gym.attacks import patch_training
from avsec_gym.attacks.attack import Victim
from avsec_gym.attacks.patch import PatchAttack
from avsec_gym.attacks.patch_configuration import PatchTraining
from avsec_gym.attacks.patch_files import Patch, PatchCard, load_patch, save_patch
from avsec_gym.attacks.patch_ghosts import FULL_CAR, ghost_box, target_boxes
from avsec_gym.attacks.patch_placement import PatchRange, random_place
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import box_corners, project
from avsec_gym.perception.detectors.recorded import Oracle
from avsec_gym.rig import kitti_rig

CALIBRATION = kitti_rig().calibration
SIZE = (375, 1242)
NEAR = PatchRange(nearest=5.0, farthest=20.0)


def frame() -> SensorFrame:
    images = {camera: np.full((*SIZE, 3), 127, np.uint8) for camera in (2, 3)}
    return SensorFrame("000000", CALIBRATION, images)


@pytest.mark.parametrize("width", [1.0, 1.3, FULL_CAR[1]])
def test_a_ghost_has_its_width_wherever_the_patch_stands(width: float) -> None:
    """Seen from above, a rectangle whose rear lies at the patch's depth, by shapely."""
    distances = []
    for seed in range(60):
        place = random_place(CALIBRATION, SIZE, seed, range=NEAR)
        ghost = ghost_box(place, CALIBRATION, width)
        corners = box_corners(ghost.location, ghost.dimensions, ghost.rotation_y)[0]
        from_above = Polygon(corners[:, [0, 2]]).convex_hull
        (x, _, z), length = ghost.location[0], width * FULL_CAR[2] / FULL_CAR[1]
        expected = box(x - width / 2, z - length / 2, x + width / 2, z + length / 2)
        assert from_above.symmetric_difference(expected).area < 1e-9
        pixels, depth = project(CALIBRATION.projection(2), corners)
        rear = pixels[np.argsort(depth)[:4]]
        assert rear[:, 0].mean() == pytest.approx(place.u, abs=1e-6)
        assert rear[:, 1].min() - 1e-6 <= place.v <= rear[:, 1].max() + 1e-6
        assert ghost.dimensions[0, 0] == pytest.approx(width * FULL_CAR[0] / FULL_CAR[1])
        assert ghost.location[0, 1] <= 1.65 + 1e-9
        distances.append(depth.min())
    assert min(distances) >= 5 - 1e-6
    assert min(distances) < 6.5
    assert max(distances) > 14


def test_without_a_width_a_near_ghost_is_smaller_than_a_far_one() -> None:
    place = random_place(CALIBRATION, SIZE, 1, range=PatchRange(nearest=5.0, farthest=5.5))
    small, full = (ghost_box(place, CALIBRATION, width) for width in (None, FULL_CAR[1]))
    # A disc of 76 pixels is 0.53 m wide at 5 m.
    assert 0.5 < small.width[0] < 0.6
    assert full.width[0] == FULL_CAR[1]
    assert small.location[0, 0] == pytest.approx(full.location[0, 0])


def test_targets_hold_the_ghost_of_that_width_and_leave_out_what_it_covers() -> None:
    place = random_place(CALIBRATION, SIZE, 1, range=PatchRange(nearest=5.0, farthest=5.5))
    small, full = (ghost_box(place, CALIBRATION, width) for width in (1.0, FULL_CAR[1]))
    # Behind the small one, within the full one.
    behind = replace(full, location=full.location + np.array([0.0, 0.0, full.length[0] - 0.2]))
    behind = replace(behind, dimensions=np.array([[1.5, 1.0, full.length[0] - 0.3]]))
    assert len(target_boxes(place, CALIBRATION, behind, 1.0)) == 2
    assert len(target_boxes(place, CALIBRATION, behind, FULL_CAR[1])) == 1
    assert target_boxes(place, CALIBRATION, None, 1.0).location == pytest.approx(small.location)


@pytest.mark.parametrize("width", [0.0, 2.0, float("nan"), "car"])
def test_ghosts_that_no_car_has_are_refused(width: Any) -> None:
    place = random_place(CALIBRATION, SIZE, 0)
    for made in (
        lambda: ghost_box(place, CALIBRATION, width),
        lambda: PatchTraining(ghost_width=width),
    ):
        with pytest.raises(ConfigurationError, match="ghost_width"):
            made()


class Scenes:
    def __len__(self) -> int:
        return 2

    def __getitem__(self, index: int) -> tuple[SensorFrame, Boxes3D]:
        return frame(), Boxes3D.empty()

    def description(self) -> dict[str, Any]:
        return {"frames": 2}


def test_a_training_draws_ghosts_of_its_width_at_its_distances(tmp_path: Path) -> None:
    settings = PatchTraining(ghost_width=1, range=PatchRange(nearest=5.0, farthest=7.0))
    assert settings.ghost_width == 1.0
    run = patch_training._Run({}, Scenes(), settings, tmp_path, resume=False)
    for seed in range(20):
        _, place, target = run._drawn(0, [seed])
        assert target.width.tolist() == [1.0]
        assert target.location == pytest.approx(ghost_box(place, CALIBRATION, 1.0).location)
        rear = target.location[0, 2] - target.length[0] / 2
        assert 4.99 < rear < 7.01
    run.curves.close()


def test_a_patch_stands_where_it_was_trained_and_knows_its_ghosts(tmp_path: Path) -> None:
    training = {"ghost_width": 1.3, "range": vars(PatchRange(nearest=5.0, farthest=7.0))}
    patch = Patch(Patch.grey().pixels, card=PatchCard(training=training))
    save_patch(tmp_path / "near.safetensors", patch)
    near, usual = PatchAttack(tmp_path / "near.safetensors"), PatchAttack("grey")
    assert (near.ghost_width, usual.ghost_width) == (1.3, None)
    assert near.stands_in == PatchRange(nearest=5.0, farthest=7.0)
    assert usual.stands_in == PatchRange()
    victim = Victim(Oracle(), Boxes3D.empty())
    depths = [721.5377 * 0.54 / near.placed(frame(), victim, seed).disparity for seed in range(20)]
    assert 4.9 < min(depths) <= max(depths) < 7.3
    asked = PatchAttack(
        tmp_path / "near.safetensors", range=PatchRange(nearest=15.0, farthest=20.0)
    )
    assert asked.stands_in.nearest == 15.0


def test_shipped_patches_stand_where_they_stood() -> None:
    for name in ("dsgn", "stereo_rcnn", "joint"):
        attack = PatchAttack(
            Path(patch_training.__file__).parent / "patches" / f"{name}.safetensors"
        )
        assert attack.stands_in == PatchRange()
        assert attack.ghost_width is None


@pytest.mark.parametrize(
    "training", [{"ghost_width": 3.0}, {"range": {"nearest": -1}}, {"range": 5}]
)
def test_a_card_that_states_what_cannot_be_is_refused(
    tmp_path: Path, training: dict[str, Any]
) -> None:
    path = tmp_path / "patch.safetensors"
    save_patch(path, Patch.grey())
    card = json.loads(path.with_suffix(".json").read_text())
    path.with_suffix(".json").write_text(json.dumps(card | {"training": training}))
    with pytest.raises(DataError, match=r"patch\.json"):
        load_patch(path)
