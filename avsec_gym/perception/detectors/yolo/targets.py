"""Which of a network's boxes stand for objects, and which are to be background."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from avsec_gym.perception.detectors.image_truth import ImageTruth
from avsec_gym.perception.detectors.yolo.box_coding import decoded_boxes, place_in_cells
from avsec_gym.perception.detectors.yolo.configuration import STRIDES, YoloConfiguration
from avsec_gym.perception.detectors.yolo.network import YoloOutput
from avsec_gym.perception.nn.box_coding import overlaps


@dataclass(frozen=True, eq=False)
class YoloTargets:
    """Targets of B images with P boxes each and N objects in all.

    With these fixed, the loss is a smooth function of the pixels.

    Args:
        image: The image of each object, shape (N,).
        box: The box that stands for each object, shape (N,).
        offsets: sigmoid(t_x), sigmoid(t_y), shape (N, 2).
        sizes: t_w, t_h, shape (N, 2).
        classes: The classes, from 0 on, shape (N,).
        weights: The weights of place and size: 2 less the object's share of the image, shape (N,).
        judged: Boxes whose objectness is learned, shape (B, P).
    """

    image: Tensor
    box: Tensor
    offsets: Tensor
    sizes: Tensor
    classes: Tensor
    weights: Tensor
    judged: Tensor


@torch.no_grad()
def find_targets(
    output: YoloOutput,
    truths: Sequence[ImageTruth],
    size: tuple[int, int],
    configuration: YoloConfiguration,
) -> YoloTargets:
    """What a network's boxes are to learn.

    The prior of most similar size, in the cell of the object's centre, stands for an object; other
    boxes that overlap one by more than the configuration's `ignored_overlap` are not judged.

    Args:
        output: The output of B images.
        truths: The objects of the same.
        size: Height and width of the network's input.
        configuration: The configuration of the network.
    """
    found = decoded_boxes(output)
    judged = torch.ones_like(output.objectness, dtype=torch.bool)
    images, boxes, offsets, sizes, classes, weights = [], [], [], [], [], []
    for number, truth in enumerate(truths):
        # A box that overlaps an object well is not judged, whether or not it stands for it.
        known = torch.cat([truth.boxes, truth.ignored])
        if len(known):
            most = overlaps(found[number], known).amax(1)
            judged[number, most > configuration.ignored_overlap] = False
        # What stands for an object is judged all the same, and learns its place and size.
        objects, index = _standing_for(truth.boxes, size, configuration)
        true = truth.boxes[objects]
        judged[number, index] = True
        offset, log_size = place_in_cells(true, output, index)
        images.append(torch.full_like(index, number))
        boxes.append(index)
        offsets.append(offset)
        sizes.append(log_size)
        classes.append(truth.classes[objects])
        # Small objects count more, up to twice.
        weights.append(2 - _area(true) / (size[0] * size[1]))
    return YoloTargets(
        torch.cat(images),
        torch.cat(boxes),
        torch.cat(offsets),
        torch.cat(sizes),
        torch.cat(classes),
        torch.cat(weights),
        judged,
    )


def _standing_for(
    boxes: Tensor, size: tuple[int, int], configuration: YoloConfiguration
) -> tuple[Tensor, Tensor]:
    """Objects, and the box of the output that stands for each, shape (M,) each.

    Where one box would have to stand for two objects, it does for the larger one.
    """
    boxes = boxes[(order := _area(boxes).argsort(stable=True))]
    sides = boxes[:, 2:] - boxes[:, :2] + 1
    priors = overlaps(_at_origin(sides), _at_origin(boxes.new_tensor(configuration.priors)))
    best = priors.argmax(1)

    strides = torch.tensor(STRIDES, device=boxes.device)
    rows, columns = size[0] // strides, size[1] // strides
    number = rows * columns * configuration.each
    level = best // configuration.each
    u, v = ((boxes[:, :2] + sides / 2) / strides[level, None]).long().unbind(1)
    u, v = u.clamp(min=0).minimum(columns[level] - 1), v.clamp(min=0).minimum(rows[level] - 1)
    index = (number.cumsum(0) - number)[level]
    index += (v * columns[level] + u) * configuration.each + best % configuration.each
    owner = dict(zip(index.tolist(), order.tolist(), strict=True))  # The last one stays.
    return order.new_tensor(list(owner.values())), order.new_tensor(list(owner))


def _at_origin(sides: Tensor) -> Tensor:
    return torch.cat((torch.zeros_like(sides), sides - 1), 1)


def _area(boxes: Tensor) -> Tensor:
    return (boxes[:, 2:] - boxes[:, :2] + 1).prod(-1)
