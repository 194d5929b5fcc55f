"""How well Stereo R-CNN's boxes fit: what its scores learn beside the class.

A class states that a car stands about here; average precision at an overlap of 0.7 asks whether the
box stands where the car does (IoU-Net: Jiang et al., ECCV 2018).  The depth of a box comes from
dense alignment, which the network cannot foresee; what is learned is how well the box fits once its
visible faces stand as far away as the car's do.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from avsec_gym.box_overlap import box_iou
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.stereo_rcnn.box_solver import solve_boxes
from avsec_gym.perception.detectors.stereo_rcnn.decoding import (
    SelectedPairs,
    decoded_pairs,
    decoded_sizes,
    observed_boxes,
)
from avsec_gym.perception.detectors.stereo_rcnn.heads import KeypointOutput, PairBoxOutput
from avsec_gym.perception.detectors.stereo_rcnn.keypoints import StereoTruth
from avsec_gym.perception.detectors.stereo_rcnn.stereo_camera import StereoCamera
from avsec_gym.perception.detectors.stereo_rcnn.targets import PairSamples
from avsec_gym.perception.nn.box_coding import overlaps


def fit_loss(logits: Tensor, targets: Tensor) -> Tensor:
    """Mean binary cross entropy over the regions whose fit is known.

    Args:
        logits: The logits of the fit, shape (B, R).
        targets: The fit, NaN where it is not known, shape (B, R).
    """
    known = targets.isfinite()
    return functional.binary_cross_entropy_with_logits(logits[known], targets[known].to(logits))


@torch.no_grad()
def fit_targets(
    boxes: PairBoxOutput,
    keypoints: KeypointOutput,
    sampling: PairSamples,
    truths: Sequence[StereoTruth],
    cameras: Sequence[StereoCamera],
    size: tuple[int, int],
) -> Tensor:
    """How well the box of each region fits as the network predicts it now, shape (B, R).

    The intersection over union in space with its object, 0 on the background, NaN on objects
    without any keypoint.

    Args:
        boxes: The boxes for the sampled regions.
        keypoints: The keypoints for those that have any, see `PairSamples.with_keypoints`.
        sampling: The sampled regions.
        truths: The objects of each image, in pixels of the network's input.
        cameras: The camera of each pair.
        size: Height and width of the network's input.
    """
    fit = torch.where(sampling.labels > 0, torch.nan, 0.0).to(sampling.left)
    for image, rows in enumerate(sampling.keypoint_order()):
        # Filling, where another image has more keypoints, comes last.
        rows = rows[sampling.labels[image, rows] > 0]
        if not len(rows):
            continue
        labels = sampling.labels[image, rows]
        regions, right = sampling.left[image, rows], sampling.right[image, rows]
        deltas = boxes.box_deltas[image, rows, labels].to(regions)
        sizes = decoded_sizes(boxes.dimensions_orientation[image, rows, labels].to(regions))
        pairs = decoded_pairs(regions, right, deltas, size)
        selected = SelectedPairs(regions, *pairs, regions.new_ones(len(rows)), labels, sizes)
        # The object that the region belongs to, by the rule of the other targets.
        true_left = torch.as_tensor(truths[image].left).to(regions)
        owner = overlaps(regions, true_left).argmax(1).cpu().numpy()
        found = _fit(selected, keypoints, image, truths[image], owner, cameras[image], size)
        fit[image, rows] = torch.from_numpy(found).to(fit)
    return fit


def _fit(
    selected: SelectedPairs,
    keypoints: KeypointOutput,
    image: int,
    truth: StereoTruth,
    owner: Floats,
    camera: StereoCamera,
    size: tuple[int, int],
) -> Floats:
    """Of N boxes of an image, each with its own object, shape (N,)."""
    observed = observed_boxes(selected, keypoints, image, size, camera)
    place, dimensions, alpha = truth.location[owner], truth.dimensions[owner], truth.alpha[owner]
    solved = solve_boxes(observed, camera, place[:, 2])
    # Along the line of sight, until the visible faces are where the object's are.
    found_alpha = solved.rotation_y - _bearing(solved.location)
    shift = _reach(observed.dimensions, found_alpha) - _reach(dimensions, alpha)
    location = solved.location * (1 + shift / place[:, 2])[:, None]
    overlap = box_iou(
        location, observed.dimensions, solved.rotation_y,
        place, dimensions, alpha + _bearing(place),
    )  # fmt: skip
    return np.where(solved.valid, np.diagonal(overlap), 0.0)


def _bearing(location: Floats) -> Floats:
    return np.asarray(np.arctan2(location[:, 0], location[:, 2]))


def _reach(dimensions: Floats, alpha: Floats) -> Floats:
    """How far before the centre of a box its surface is seen, metres, shape (N,)."""
    _, width, length = dimensions.T
    cos, sin = (np.maximum(np.abs(part), 1e-6) for part in (np.cos(alpha), np.sin(alpha)))
    return np.asarray(np.minimum(width / cos, length / sin) / 2)
