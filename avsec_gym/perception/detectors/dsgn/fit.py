"""How well DSGN's boxes fit: what its scores learn beside the class.

A class states that a car stands about here; average precision at an overlap of 0.7 asks whether the
box stands where the car does (IoU-Net: Jiang et al., ECCV 2018).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.box_overlap import box_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.detectors.dsgn.anchors import boxes_of_corners
from avsec_gym.perception.detectors.dsgn.box_field import AnchorIndex
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.losses import at_least_single
from avsec_gym.perception.detectors.dsgn.network import DsgnOutput
from avsec_gym.perception.detectors.dsgn.targets import AnchorTargets, objects_to_learn

_BEST = 64
"""Anchors of an image, by class, that learn their fit beside those that stand for an object: the
likely candidates, false alarms among them."""


def fit_loss(
    output: DsgnOutput,
    truth: Sequence[Boxes3D],
    targets: AnchorTargets,
    configuration: DsgnConfiguration,
    categories: Sequence[str],
) -> Tensor:
    """Mean binary cross entropy of the fit against the overlap of the box as it is now.

    The anchors are those that stand for an object, and the most likely others.

    Args:
        output: The output of the network, with `fit`.
        truth: Objects of each pair.
        targets: The targets of the same batch.
        configuration: Anchors and grid.
        categories: Classes that are learned.
    """
    assert output.fit is not None
    index = _learning(output.class_logits, targets)
    wanted = box_fit(output, index, truth, configuration, categories)
    logits = at_least_single(output.fit)[index]
    return functional.binary_cross_entropy_with_logits(logits, wanted.to(logits))


@torch.no_grad()
def box_fit(
    output: DsgnOutput,
    index: AnchorIndex,
    truth: Sequence[Boxes3D],
    configuration: DsgnConfiguration,
    categories: Sequence[str],
) -> Tensor:
    """The largest intersection over union in space with an object of its class, shape (P,)."""
    image, _, kind, row, column = (part.cpu().numpy() for part in index)
    heights = np.array([anchor.centre_y for anchor in configuration.anchors])
    x, z = configuration.grid.x.centres(), configuration.grid.z.centres()
    place = np.stack([x[column], heights[kind], z[row]], axis=-1)[:, None]
    corners = output.boxes.at(index).double().cpu().numpy() + place
    location, dimensions, rotation_y = boxes_of_corners(corners)
    fit = np.zeros(len(image))
    for i, boxes in enumerate(truth):
        objects, classes = objects_to_learn(boxes, configuration, categories)
        rows = np.flatnonzero(image == i)
        if not len(objects) or not len(rows):
            continue
        overlap = box_iou(
            location[rows], dimensions[rows], rotation_y[rows],
            objects.location, objects.dimensions, objects.rotation_y,
        )  # fmt: skip
        fit[rows] = np.where(kind[rows, None] == classes, overlap, 0.0).max(axis=1)
    return torch.from_numpy(fit)


@torch.no_grad()
def _learning(class_logits: Tensor, targets: AnchorTargets) -> AnchorIndex:
    """Anchors that learn their fit, each once."""
    chosen = torch.zeros_like(class_logits, dtype=torch.bool)
    flat = class_logits.flatten(1)
    best = flat.topk(min(_BEST, flat.shape[1]), dim=1).indices
    chosen.flatten(1).scatter_(1, best, True)
    chosen[tuple(part.to(chosen.device) for part in targets.index)] = True
    image, angle, kind, row, column = chosen.nonzero(as_tuple=True)
    return image, angle, kind, row, column
