"""Which box stands for an object, what it should say, and what it costs."""

from __future__ import annotations

import math
from dataclasses import replace

import torch

from avsec_gym.perception.detectors.image_truth import ImageTruth
from avsec_gym.perception.detectors.yolo.box_coding import decoded_boxes, place_in_cells
from avsec_gym.perception.detectors.yolo.configuration import SMALL
from avsec_gym.perception.detectors.yolo.losses import TERMS, detection_terms
from avsec_gym.perception.detectors.yolo.network import YoloOutput, box_grid
from avsec_gym.perception.detectors.yolo.targets import YoloTargets, find_targets
from avsec_gym.perception.nn.box_coding import overlaps

TWO = replace(SMALL, categories=("Car", "Pedestrian"))
OBJECTS = torch.tensor([[10.0, 10, 21, 20], [100, 5, 199, 60], [40, 20, 81, 52]]).double()
NOTHING = torch.zeros(0, 4).double()
TRUTH = ImageTruth(OBJECTS, torch.tensor([0, 1, 0]), NOTHING)
HEIGHT, WIDTH = 64, 224


def _output(seed: int = 0, images: int = 1) -> YoloOutput:
    shapes = [(HEIGHT // stride, WIDTH // stride) for stride in (8, 16, 32)]
    cells, strides, priors = (values.double() for values in box_grid(shapes, TWO))
    generator = torch.Generator().manual_seed(seed)
    logits = torch.randn(images, len(cells), 7, generator=generator, dtype=torch.float64)
    return YoloOutput(logits, cells, strides, priors)


def _targets(output: YoloOutput, *truths: ImageTruth) -> YoloTargets:
    return find_targets(output, truths, (HEIGHT, WIDTH), TWO)


def test_what_a_box_should_say_decodes_to_the_object() -> None:
    output = _output()
    targets = _targets(output, TRUTH)
    offsets, sizes = place_in_cells(OBJECTS[[0]], output, targets.box[[0]])
    torch.testing.assert_close((offsets, sizes), (targets.offsets[[0]], targets.sizes[[0]]))
    assert ((targets.offsets >= 0) & (targets.offsets < 1)).all()
    logits = output.logits.clone()
    logits[targets.image, targets.box, :2] = torch.logit(targets.offsets)
    logits[targets.image, targets.box, 2:4] = targets.sizes
    decoded = decoded_boxes(replace(output, logits=logits))[0, targets.box]
    # Smallest first.
    torch.testing.assert_close(decoded, OBJECTS[[0, 2, 1]])
    assert targets.classes.tolist() == [0, 0, 1]


def test_boxes_by_the_paper_s_formulas() -> None:
    output = _output()
    decoded = decoded_boxes(output)
    for i in (0, 700, len(output.cells) - 1):
        tx, ty, tw, th = output.logits[0, i, :4].tolist()
        (cx, cy), (pw, ph) = output.cells[i].tolist(), output.priors[i].tolist()
        stride = float(output.strides[i])
        bx, by = (stride * (c + 1 / (1 + math.exp(-t))) for c, t in ((cx, tx), (cy, ty)))
        bw, bh = pw * math.exp(tw), ph * math.exp(th)
        expected = [bx - bw / 2, by - bh / 2, bx + bw / 2 - 1, by + bh / 2 - 1]
        torch.testing.assert_close(
            decoded[0, i], torch.tensor(expected).double(), rtol=1e-6, atol=1e-5
        )


def test_the_most_similar_prior_in_the_centre_s_cell_stands_for_an_object() -> None:
    """By plain search over every box of the output."""
    output = _output()
    targets = _targets(output, TRUTH)
    for box, row in zip(OBJECTS[[0, 2, 1]].tolist(), targets.box.tolist(), strict=True):
        x1, y1, x2, y2 = box
        w, h = x2 - x1 + 1, y2 - y1 + 1
        best, expected = 0.0, -1
        for i in range(len(output.cells)):
            (column, line), (pw, ph) = output.cells[i].tolist(), output.priors[i].tolist()
            stride = float(output.strides[i])
            here = (column, line) == ((x1 + w / 2) // stride, (y1 + h / 2) // stride)
            common = min(w, pw) * min(h, ph)
            similar = common / (w * h + pw * ph - common)
            if here and similar > best:
                best, expected = similar, i
        assert row == expected
    share = 100 * 56 / (HEIGHT * WIDTH)
    torch.testing.assert_close(float(targets.weights[2]), 2 - share)


def test_the_larger_of_two_in_one_place() -> None:
    twice = torch.cat([OBJECTS[:1], OBJECTS[:1] + torch.tensor([-0.5, -0.5, 0.5, 0.5])])
    truth = ImageTruth(twice, torch.tensor([1, 0]), NOTHING)
    targets = _targets(_output(), truth)
    assert targets.classes.tolist() == [0]


def test_good_boxes_of_others_are_not_judged() -> None:
    output = _output()
    van = decoded_boxes(output)[0, [5]]
    targets = _targets(output, replace(TRUTH, ignored=van))
    found = decoded_boxes(output)[0]
    near = (overlaps(found, torch.cat([OBJECTS, van])) > 0.5).any(1)
    near[targets.box] = False
    assert torch.equal(~targets.judged[0], near)
    assert near[5]


def test_terms_by_plain_sums() -> None:
    output = _output(images=2)
    truths = TRUTH, ImageTruth(NOTHING, torch.zeros(0, dtype=torch.long), NOTHING)
    targets = _targets(output, *truths)
    terms = detection_terms(output, targets)
    sums = dict.fromkeys(TERMS, 0.0)

    def cross_entropy(logit: float, truth: float) -> float:
        probability = 1 / (1 + math.exp(-logit))
        return -truth * math.log(probability) - (1 - truth) * math.log(1 - probability)

    for n in range(len(targets.box)):
        logits = output.logits[0, targets.box[n]].tolist()
        weight = float(targets.weights[n])
        for k in range(2):
            sums["centre"] += weight * cross_entropy(logits[k], float(targets.offsets[n, k]))
            sums["size"] += weight * (logits[2 + k] - float(targets.sizes[n, k])) ** 2 / 2
            sums["class"] += cross_entropy(logits[5 + k], float(k == targets.classes[n]))
    standing = set(targets.box.tolist())
    for image in range(2):
        for i in range(len(output.cells)):
            if targets.judged[image, i]:
                is_object = float(image == 0 and i in standing)
                sums["objectness"] += cross_entropy(float(output.objectness[image, i]), is_object)
    for name, value in sums.items():
        torch.testing.assert_close(float(terms[name]), value / 2)
