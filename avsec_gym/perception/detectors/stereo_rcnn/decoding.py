"""From the network's output to boxes: selection, keypoints, solver, alignment (SPEC 7)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.perception.detectors.stereo_rcnn.alignment import Alignment
from avsec_gym.perception.detectors.stereo_rcnn.box_solver import ObservedBoxes, solve_boxes
from avsec_gym.perception.detectors.stereo_rcnn.decoding_rule import StereoRcnnDecodingRule
from avsec_gym.perception.detectors.stereo_rcnn.dense_alignment import NetworkPixels, align_depths
from avsec_gym.perception.detectors.stereo_rcnn.heads import KeypointOutput, PairBoxOutput
from avsec_gym.perception.detectors.stereo_rcnn.keypoints import (
    checked_borders,
    decode_borders,
    decode_keypoints,
)
from avsec_gym.perception.detectors.stereo_rcnn.proposals import PairProposals, decode_stereo
from avsec_gym.perception.detectors.stereo_rcnn.stereo_camera import StereoCamera
from avsec_gym.perception.detectors.stereo_rcnn.targets import (
    BOX_DEVIATIONS,
    DIMENSION_DEVIATION,
    DIMENSION_MEANS,
    KEYPOINT_CELLS,
)
from avsec_gym.perception.nn.box_coding import clip_boxes
from avsec_gym.perception.nn.nms import suppress

_SMALLEST_SIDE = 0.3


@dataclass(frozen=True, eq=False)
class SelectedPairs:
    """M detections of one image, best first, in pixels of the network's input.

    Args:
        regions: The regions of the left image that they come from, shape (M, 4).
        left: Boxes in the left image, shape (M, 4).
        right: Boxes in the right image, shape (M, 4).
        scores: The scores, shape (M,).
        classes: The classes, from 1 on, shape (M,).
        sizes: Width, height, length (metres), sin and cos of the observation angle, shape (M, 5).
    """

    regions: Tensor
    left: Tensor
    right: Tensor
    scores: Tensor
    classes: Tensor
    sizes: Tensor


def select(
    proposals: PairProposals,
    output: PairBoxOutput,
    size: tuple[int, int],
    rule: StereoRcnnDecodingRule,
) -> list[SelectedPairs]:
    """What survives score and suppression, for each of B images of a size (height, width)."""
    probabilities = output.class_probabilities
    result = []
    for image in range(len(proposals.left)):
        found = []
        for label in range(1, probabilities.shape[-1]):
            # Each class by itself: what is likely is decoded, and suppressed by the left image.
            scores = probabilities[image, :, label]
            likely = (proposals.valid[image] & (scores > rule.least_score)).nonzero()[:, 0]
            if rule.fit_share and output.fit_logits is not None:
                fit = output.fit_logits[image].sigmoid()
                scores = scores ** (1 - rule.fit_share) * fit**rule.fit_share
            regions = proposals.left[image, likely]
            left, right = decoded_pairs(
                regions,
                proposals.right[image, likely],
                output.box_deltas[image, likely, label],
                size,
            )
            kept = suppress(left, scores[likely], rule.overlap)
            sizes = output.dimensions_orientation[image, likely[kept], label]
            found.append(
                (
                    regions[kept],
                    left[kept],
                    right[kept],
                    scores[likely[kept]],
                    torch.full_like(kept, label),
                    decoded_sizes(sizes),
                )
            )
        # All classes together, best first.
        columns = [torch.cat(column) for column in zip(*found, strict=True)]
        order = torch.argsort(columns[3], descending=True, stable=True)
        result.append(SelectedPairs(*(column[order] for column in columns)))
    return result


def decoded_pairs(
    left: Tensor, right: Tensor, deltas: Tensor, size: tuple[int, int]
) -> tuple[Tensor, Tensor]:
    """The boxes in both images, each (N, 4), that the box head's deltas (N, 6) mean.

    Args:
        left: Regions of the left image, shape (N, 4).
        right: Regions of the right image, shape (N, 4).
        deltas: The deltas as in `PairBoxOutput`, shape (N, 6).
        size: Height and width of the network's input.
    """
    boxes = decode_stereo(left, right, deltas * deltas.new_tensor(BOX_DEVIATIONS))
    # Decoded boxes end beyond their last pixel; half a metre of depth hangs on such a pixel.
    beyond = deltas.new_tensor([0, 0, 1, 1])
    first, second = (clip_boxes(box - beyond, *size) for box in boxes)
    return first, second


def decoded_sizes(sizes: Tensor) -> Tensor:
    """Width, height, length (metres), sin and cos of the angle, of the box head's numbers."""
    return sizes * DIMENSION_DEVIATION + sizes.new_tensor(DIMENSION_MEANS)


def observed_boxes(
    selected: SelectedPairs,
    keypoints: KeypointOutput,
    image: int,
    size: tuple[int, int],
    camera: StereoCamera,
) -> ObservedBoxes:
    """What the solver takes, in the camera's pixels.

    Args:
        selected: M detections.
        keypoints: The keypoints for at least M regions, the first being theirs.
        image: The one of `keypoints`' images that it is.
        size: Height and width of the network's input.
        camera: The camera of images that may have another size.
    """
    scale_v, scale_u = camera.size[0] / size[0], camera.size[1] / size[1]
    count = len(selected.scores)
    regions, left, right, sizes = (
        part.double().cpu().numpy()
        for part in (selected.regions, selected.left, selected.right, selected.sizes)
    )
    cells = keypoints.corner_logits[image, :count].argmax(-1).cpu().numpy()
    border_cells = keypoints.border_logits[image, :count].argmax(-1).cpu().numpy()
    keypoint, corner = decode_keypoints(cells, regions, KEYPOINT_CELLS)
    borders = decode_borders(border_cells, regions, KEYPOINT_CELLS)
    scale = np.array([scale_u, scale_v, scale_u, scale_v])
    left, right = ((box + 0.5) * scale - 0.5 for box in (left, right))
    keypoint, borders = ((u + 0.5) * scale_u - 0.5 for u in (keypoint, borders))
    return ObservedBoxes(
        left,
        right,
        keypoint,
        corner,
        checked_borders(borders, left, camera.size[1]),
        np.maximum(sizes[:, [1, 0, 2]], _SMALLEST_SIDE),
        np.arctan2(sizes[:, 3], sizes[:, 4]),
    )


def keypoint_certainty(keypoints: KeypointOutput, image: int, count: int) -> Floats:
    """The probability of the keypoint's column in each of an image's first regions, (count,)."""
    probabilities = keypoints.corner_logits[image, :count].softmax(-1)
    return np.asarray(probabilities.amax(-1).double().cpu().numpy())


@dataclass(frozen=True, eq=False)
class EvidencedBoxes:
    """Boxes, and what speaks for each of them beside its class.

    Args:
        boxes: The N boxes, with the network's own scores.
        evidence: The evidence in the order of `EVIDENCE`, shape (N, 3).
    """

    boxes: Boxes3D
    evidence: Floats


EVIDENCE = ("shifted", "contrast", "keypoint")
"""How far alignment moved the box, as a share of its depth; `AlignedDepths.contrast`;
`keypoint_certainty`."""


def solved_boxes(
    observed: ObservedBoxes,
    scores: Floats,
    certainty: Floats,
    categories: Sequence[str],
    images: tuple[NetworkPixels, NetworkPixels],
    camera: StereoCamera,
    alignment: Alignment,
) -> EvidencedBoxes:
    """Boxes in KITTI's frame; those without a solution are left out.

    Args:
        observed: N detections.
        scores: The scores, shape (N,).
        certainty: The certainty of their keypoints, shape (N,).
        categories: The category of each one.
        images: Left and right.
        camera: The camera that took them.
        alignment: How the depth is searched.
    """
    solved = solve_boxes(observed, camera)
    fit = solved.valid
    observed, scores, solved = observed[fit], scores[fit], solved[fit]
    depths = align_depths(*images, observed, solved, camera, alignment)
    aligned = solve_boxes(observed, camera, depths.depth)
    better = depths.found & aligned.valid
    location = np.where(better[:, None], aligned.location, solved.location) - camera.offset
    rotation_y = np.where(better, aligned.rotation_y, solved.rotation_y)
    shifted = np.abs(depths.depth - solved.location[:, 2]) / np.maximum(depths.depth, 1.0)
    boxes = Boxes3D(
        location,
        observed.dimensions,
        rotation_y,
        scores,
        np.array(categories, np.str_)[fit],
        box2d=observed.left,
        alpha=wrap_angle(rotation_y - np.arctan2(location[:, 0], location[:, 2])),
    )
    evidence = [shifted, depths.contrast, certainty[fit]]
    return EvidencedBoxes(boxes, np.column_stack(evidence))
