"""A part of a stereo pair enlarged to the full size, as cameras with longer lenses would see it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.training.sample import Map, Pixels, StereoSample


def zoomed(sample: StereoSample, factor: float, left: float, top: float) -> StereoSample:
    """The window of ``1 / factor`` of width and height, enlarged to the sample's size.

    Both views get the same window, so that rows still match and disparities grow by the factor;
    the projections follow.  Objects outside of the window are left out.

    Args:
        sample: The sample before.
        factor: 1 or more.
        left: Where the window is, as a share of the room that there is: 0 left, 1 right.
        top: 0 top, 1 bottom.
    """
    height, width = sample.size
    # Where the middle of pixel (u, v) goes: u' = factor * (u + 1/2 - start) - 1/2.
    start_u, start_v = (
        share * size * (1 - 1 / factor) for share, size in ((left, width), (top, height))
    )
    offset_u, offset_v = (factor * (0.5 - start) - 0.5 for start in (start_u, start_v))
    change = np.array([[factor, 0, offset_u], [0, factor, offset_v], [0, 0, 1.0]])

    def disparity(values: Map) -> Map:
        # Nearest, not between: no disparities between two surfaces.
        return _warped(values, change, linear=False) * np.float32(factor)

    return StereoSample(
        _warped(sample.left, change, linear=True),
        _warped(sample.right, change, linear=True),
        change @ sample.left_projection,
        change @ sample.right_projection,
        disparity(sample.left_disparity),
        disparity(sample.right_disparity),
        _zoomed_boxes(sample, change),
    )


def _zoomed_boxes(sample: StereoSample, change: np.ndarray) -> Boxes3D:
    boxes = sample.truth
    if boxes.box2d is None or not len(boxes):
        return boxes
    height, width = sample.size
    moved = boxes.box2d * change[0, 0] + np.tile(change[:2, 2], 2)
    cut = np.clip(moved, 0, np.tile([width - 1, height - 1], 2))
    inside = (cut[:, 2] - cut[:, 0]) * (cut[:, 3] - cut[:, 1])
    visible = inside / np.maximum((moved[:, 2] - moved[:, 0]) * (moved[:, 3] - moved[:, 1]), 1e-9)
    truncation = boxes.truncation
    if truncation is not None:
        known = truncation >= 0
        truncation = np.where(known, 1 - (1 - truncation) * np.minimum(visible, 1), truncation)
    return replace(boxes, box2d=cut, truncation=truncation)[visible > 0]


def _warped(image: Pixels | Map, change: np.ndarray, *, linear: bool) -> np.ndarray:
    import cv2

    return np.asarray(
        cv2.warpAffine(
            image,
            change[:2],
            (image.shape[1], image.shape[0]),
            flags=cv2.INTER_LINEAR if linear else cv2.INTER_NEAREST,
            borderMode=cv2.BORDER_REPLICATE,
        )
    )
