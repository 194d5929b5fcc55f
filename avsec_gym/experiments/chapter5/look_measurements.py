"""What is measured at a look: changes of pixels, where a patch is, and the losses it aims at."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from avsec_gym.attacks.attack import LEFT, RIGHT, Victim
from avsec_gym.attacks.loss_gradient import total_loss
from avsec_gym.attacks.patch_ghosts import ghost_box, target_boxes
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.looks import CellLook
from avsec_gym.experiments.chapter5.settings import setting
from avsec_gym.frame import SensorFrame
from avsec_gym.metrics.ghosts import iou_from_above
from avsec_gym.perception.detectors.detector import DifferentiableDetector
from avsec_gym.perception.stereo_batch import batch_of_frames
from avsec_gym.runs.experiment import Measurement
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene


def look_measurements(
    look: CellLook,
    scene: Scene,
    clean: SensorFrame,
    victim: Victim,
    believed: Boxes3D,
    *,
    losses: bool,
) -> list[Measurement]:
    """The largest change of a grey level, a patch's place, and the losses that it aims at.

    ``loss`` is that to the truth, which perturbations raise; ``ghost_loss`` that to b*, which a
    patch lowers, from ``clean_ghost_loss``, measured where it is placed at random; ``ghost_seen``
    is 1 where the planner gets a box that meets the patch's ghost on the ground.

    Args:
        look: The frame that the car was shown.
        scene: The scene that it is of.
        clean: Its frame without an attack.
        victim: The detector, and what the attack knew of the scene.
        believed: The boxes that were planned on.
        losses: Whether losses are measured.
    """
    before = clean if look.attacked is None else look.attacked
    changes = [
        np.abs(np.subtract(look.frame.image(camera), before.image(camera), dtype=float)).max()
        for camera in (LEFT, RIGHT)
    ]
    numbers = {"change": float(max(changes))}
    detector = victim.detector if losses else None
    if look.place is None:
        if isinstance(detector, DifferentiableDetector):
            numbers["loss"] = _loss(detector, look.frame, victim.truth, victim.disparity)
    else:
        aim = look.place.intention(clean.image(LEFT).shape[1])
        numbers["attack_intention"] = list(Intention).index(aim)
        ghost = ghost_box(look.place, clean.calibration, look.ghost_width)
        overlap = iou_from_above(believed, ghost)
        numbers["ghost_seen"] = float((overlap > 0).any())
        if not look.seen_as and isinstance(detector, DifferentiableDetector):
            ghosts = target_boxes(look.place, clean.calibration, victim.truth, look.ghost_width)
            numbers["clean_ghost_loss"] = _loss(detector, clean, ghosts)
            numbers["ghost_loss"] = _loss(detector, look.frame, ghosts)
    filed = setting(victim.detector.name, look.seen_as or look.attack)
    return [
        Measurement(filed, scene.id, name, value, look.strength) for name, value in numbers.items()
    ]


def _loss(
    detector: DifferentiableDetector,
    frame: SensorFrame,
    boxes: Boxes3D,
    disparity: NDArray[np.float32] | None = None,
) -> float:
    known = None if disparity is None else torch.from_numpy(disparity)[None]
    with torch.no_grad():
        return float(total_loss(detector, batch_of_frames([frame]), [boxes], known))
