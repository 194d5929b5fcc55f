"""Training a patch: the loss to b* falls, both detectors count, resuming changes nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.attacks import patch_training
from avsec_gym.attacks.loss_gradient import total_loss
from avsec_gym.attacks.patch_configuration import PatchTraining
from avsec_gym.attacks.patch_files import Patch, load_patch
from avsec_gym.attacks.patch_ghosts import target_boxes
from avsec_gym.attacks.patch_pasting import paste
from avsec_gym.attacks.patch_placement import PatchPlace, random_place
from avsec_gym.attacks.patch_training import PATCH, train_patch
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.recorded import Oracle
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
from avsec_gym.perception.training.curves import read_curves
from avsec_gym.perception.weights.weights_hash import weights_hash
from avsec_gym.rig import kitti_rig

SETTINGS = PatchTraining(epochs=8, batch=2, step_size=64, radius=12)


class StandIn:
    """Sees a ghost where its filter, one for both views, answers; its loss has some scale."""

    def __init__(self, seed: int = 0, scale: float = 1.0, name: str = "stand-in") -> None:
        self.name, self.scale = name, scale
        torch.manual_seed(seed)
        self.network = nn.Conv2d(3, 1, 8, stride=4).requires_grad_(False)

    def detect(self, frame: SensorFrame) -> Boxes3D:
        return Boxes3D.empty()

    def detect_batch(self, batch: StereoBatch) -> list[Boxes3D]:
        return [Boxes3D.empty() for _ in range(len(batch))]

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        assert disparity is None
        terms = []
        for images in (batch.left, batch.right):
            answers = self.network(images / 255)[:, 0]
            for answer, boxes in zip(answers, truth, strict=True):
                assert boxes.box2d is not None
                left, top, right, bottom = (boxes.box2d[-1].clip(0) / 4).astype(int)
                terms.append(functional.softplus(-4 * answer[top:bottom, left:right].amax()))
        return {"found": self.scale * torch.stack(terms).mean()}


class Scenes:
    """Plain walls, each of its own brightness."""

    def __init__(self, count: int = 4) -> None:
        self.count = count

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, index: int) -> tuple[SensorFrame, Boxes3D]:
        draw = np.random.default_rng(index)
        wall = np.full((110, 260, 3), draw.integers(64, 192), np.uint8)
        images = {camera: wall + draw.integers(0, 8, wall.shape, np.uint8) for camera in (2, 3)}
        return SensorFrame(f"{index:06d}", kitti_rig().calibration, images), Boxes3D.empty()

    def description(self) -> dict[str, Any]:
        return {"frames": self.count}


def expected_loss(detector: Any, patch: Patch, scenes: Scenes) -> float:
    """Over places that the training has not seen."""
    losses = []
    for index in range(len(scenes)):
        frame, truth = scenes[index]
        place = random_place(
            frame.calibration, frame.image(2).shape[:2], [99, index], radius=patch.radius
        )
        batch = paste(batch_of_frames([frame]), patch.pixels, [place])
        losses.append(
            float(total_loss(detector, batch, [target_boxes(place, frame.calibration, truth)]))
        )
    return float(np.mean(losses))


def test_the_expected_loss_to_the_ghosts_falls(tmp_path: Path) -> None:
    detector = StandIn()
    told: list[Any] = []
    epochs: dict[int, float] = {}
    patch = train_patch(
        [detector],
        Scenes(),
        SETTINGS,
        tmp_path,
        on_progress=lambda done, steps: told.append((done, steps)),
        on_epoch=lambda epoch, losses: epochs.update({epoch: losses["stand-in"]}),
    )
    curve = [row["losses"]["stand-in"] for row in read_curves(tmp_path)]
    # Four scenes, two of them in each step.
    assert epochs == {
        epoch: pytest.approx(np.mean(curve[2 * epoch - 2 : 2 * epoch])) for epoch in range(1, 9)
    }
    trained = expected_loss(detector, patch, Scenes(8))
    for control in (Patch.grey(12), Patch.noise(radius=12)):
        assert trained < 0.9 * expected_loss(detector, control, Scenes(8))
    assert torch.equal(patch.pixels, patch.pixels.round()), "printers know whole grey levels"
    assert patch.pixels.min() >= 0
    assert patch.pixels.max() <= 255
    assert told == [(step, 20) for step in range(1, 21)], "16 steps, and 4 scenes to judge on"
    assert len(read_curves(tmp_path)) == 16
    assert patch.card is not None
    assert patch.card.detectors == {"stand-in": weights_hash(detector)}
    grey = patch.card.losses["grey"]["stand-in"]
    assert patch.card.losses["patch"]["stand-in"] < grey
    assert grey == pytest.approx(judged(detector, Patch.grey(12)))
    assert torch.equal(load_patch(tmp_path / PATCH).pixels, patch.pixels)


def judged(detector: Any, patch: Patch) -> float:
    """By places that depend on the seed and the scene alone."""
    losses = []
    for index in range(4):
        frame, truth = Scenes()[index]
        size = frame.image(2).shape[:2]
        place = random_place(frame.calibration, size, [0, index, 0, 1], radius=12)
        batch = paste(batch_of_frames([frame]), patch.pixels, [place])
        target = target_boxes(place, frame.calibration, truth)
        losses.append(float(total_loss(detector, batch, [target])))
    return float(np.mean(losses))


@pytest.mark.usefixtures("undrawn_curves")
def test_a_patch_is_judged_at_places_that_no_step_drew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To numpy, the seeds [5] and [5, 0] are one."""
    draws = []

    def watched(calibration: Any, size: Any, seed: Any, **given: Any) -> PatchPlace:
        draws.append(int(np.random.default_rng(seed).integers(2**62)))
        return random_place(calibration, size, seed, **given)

    monkeypatch.setattr(patch_training, "random_place", watched)
    train_patch([StandIn()], Scenes(), SETTINGS, tmp_path)
    assert len(draws) == 8 * 4 + 4, "each scene in each epoch, and once to be judged on"
    assert len(set(draws)) == len(draws)


@pytest.mark.usefixtures("undrawn_curves")
def test_both_detectors_shape_a_joint_patch_whatever_the_scales_of_their_losses(
    tmp_path: Path,
) -> None:
    one, other = StandIn(0, 1e-3, "one"), StandIn(1, 1e3, "other")
    patch = train_patch([one, other], Scenes(), SETTINGS, tmp_path)
    for detector in (one, other):
        control = expected_loss(detector, Patch.grey(12), Scenes(8))
        assert expected_loss(detector, patch, Scenes(8)) < 0.95 * control


def test_a_detectors_gradients_are_measured_by_their_mean_size_so_far(tmp_path: Path) -> None:
    """Mean sizes of 2, then of 2 and 4: the steps count alike."""
    training = PatchTraining(radius=20.0, epochs=2, batch=1)
    run = patch_training._Run({"a": StandIn()}, Scenes(2), training, tmp_path, False)
    for step, (size, mean) in enumerate([(2.0, 2.0), (4.0, 3.0), (-9.0, 5.0)]):
        run.state.step = step
        run._descend({"a": torch.full_like(run.pixels, size)})
        assert run.sizes["a"] == pytest.approx(mean)


@pytest.mark.usefixtures("undrawn_curves")
def test_a_stopped_training_goes_on_as_if_nothing_had_happened(tmp_path: Path) -> None:
    whole = train_patch([StandIn()], Scenes(5), SETTINGS, tmp_path / "whole")

    class Stop(Exception):
        pass

    def stop(done: int, steps: int) -> None:
        if done == 5:
            raise Stop

    parts = tmp_path / "parts"
    with pytest.raises(Stop):
        train_patch([StandIn()], Scenes(5), SETTINGS, parts, on_progress=stop)
    with pytest.raises(DataError, match="--resume"):
        train_patch([StandIn()], Scenes(5), SETTINGS, parts)
    resumed = train_patch([StandIn()], Scenes(5), SETTINGS, parts, resume=True)
    assert torch.equal(resumed.pixels, whole.pixels)
    assert read_curves(parts) == read_curves(tmp_path / "whole")
    again = train_patch([StandIn()], Scenes(5), SETTINGS, parts, resume=True)
    assert torch.equal(again.pixels, whole.pixels)
    with pytest.raises(DataError, match=r"training\.seed"):
        train_patch([StandIn()], Scenes(5), replace(SETTINGS, seed=1), parts, resume=True)
    with pytest.raises(DataError, match=r"detectors\.stand-in"):
        train_patch([StandIn(7)], Scenes(5), SETTINGS, parts, resume=True)


@pytest.mark.usefixtures("undrawn_curves")
def test_other_seeds_make_other_patches(tmp_path: Path) -> None:
    short = replace(SETTINGS, epochs=1)
    one = train_patch([StandIn()], Scenes(), short, tmp_path / "0")
    other = train_patch([StandIn()], Scenes(), replace(short, seed=1), tmp_path / "1")
    assert not torch.equal(one.pixels, other.pixels)


def test_detectors_that_cannot_be_trained_against(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="different names"):
        train_patch([StandIn(), StandIn()], Scenes(), SETTINGS, tmp_path)
    with pytest.raises(ConfigurationError, match="no `losses`"):
        train_patch([Oracle()], Scenes(), SETTINGS, tmp_path)  # type: ignore[list-item]
    with pytest.raises(ConfigurationError):
        PatchTraining(epochs=0)
    with pytest.raises(ConfigurationError):
        PatchTraining(step_size=0)


@pytest.mark.usefixtures("undrawn_curves")
@pytest.mark.slow
def test_one_patch_brings_both_networks_nearer_to_a_ghost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With random weights and one place: with many, a few steps would be lost in their spread."""
    from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
    from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector

    class Street(Scenes):
        def __getitem__(self, index: int) -> tuple[SensorFrame, Boxes3D]:
            frame, truth = super().__getitem__(index)
            for camera in (2, 3):
                wall = np.resize(frame.image(camera), (375, 1242, 3))
                frame = frame.with_image(camera, wall)
            return frame, truth

    place = PatchPlace(620, 220, 28.0, 0.5)
    monkeypatch.setattr(patch_training, "random_place", lambda *_, **__: place)
    torch.manual_seed(0)
    detectors = [DsgnDetector(), StereoRcnnDetector()]
    settings = PatchTraining(epochs=6, batch=1, step_size=16)
    patch = train_patch(detectors, Street(1), settings, tmp_path)
    frame, _ = Street(1)[0]
    target = target_boxes(place, frame.calibration)
    for detector in detectors:
        trained, grey = (
            float(total_loss(detector, paste(batch_of_frames([frame]), pixels, [place]), [target]))
            for pixels in (patch.pixels, Patch.grey().pixels)
        )
        assert trained < grey - 0.01 * abs(grey)


def test_the_step_size_falls_to_a_tenth() -> None:
    settings = PatchTraining(step_size=8.0)
    sizes = [settings.step_size_at(share) for share in (0.0, 0.5, 1.0)]
    assert sizes == pytest.approx([8.0, 4.4, 0.8])
