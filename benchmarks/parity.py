"""Our networks against the outputs of the original ones, with weights filled by a rule.

    python -m benchmarks.parity ../shared/parity [--json] [--only NAME ...]

The folder's README has the rule.  An error is ``max|ours - reference| / max|reference|``, also of
mean and deviation over the whole tensor; ``parameters`` is that of the parameter count.
``--json`` prints ``{network: {output: error}}``; the exit code is 1 if an error exceeds 1e-3.
"""

from __future__ import annotations

import argparse
import json
import sys
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from rich.console import Console
from rich.table import Table
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.depth.psmnet import PsmNet, PsmNetConfiguration
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.network import DsgnNetwork
from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration
from avsec_gym.perception.detectors.pixor.network import PixorNetwork
from avsec_gym.perception.detectors.stereo_rcnn.configuration import StereoRcnnConfiguration
from avsec_gym.perception.detectors.stereo_rcnn.network import StereoRcnnNetwork

TOLERANCE = 1e-3

Errors = dict[str, float]


def psmnet(folder: Path) -> Errors:
    """At 64 disparities, on 256 x 256 pixels."""
    configuration = PsmNetConfiguration.preset("full")
    network = PsmNet(replace(configuration, disparities=64)).eval()
    fill_by_rule(network)
    left, right = random_pair(256, 256)
    outputs = {"feat": network.matching_features(left), "disp": network(left, right)[-1]}
    errors = against_reference(outputs, folder / "psmnet_256x256_d64.npz")
    return {"parameters": count_error(network, 5_224_768), **errors}


def dsgn(preset: str, reference: str, parameters: int, aligned: bool) -> Callable[[Path], Errors]:
    """On 256 x 512 pixels; `aligned` is how the world grid samples."""

    def compare(folder: Path) -> Errors:
        configuration = replace(DsgnConfiguration.preset(preset), aligned_corners=aligned)
        network = DsgnNetwork(configuration).eval()
        fill_by_rule(network)
        path = folder / reference
        projection = torch.from_numpy(np.load(path)["P"])
        output = network(*random_pair(256, 512), projection, torch.tensor([300 * 0.54]))
        outputs = {
            "depth": output.depth,
            "cls": output.class_logits,
            "reg": output.corners,
            "ctr": output.centerness,
        }
        return {
            "parameters": count_error(network, parameters),
            **against_reference(outputs, path),
        }

    return compare


def stereo_rcnn(folder: Path) -> Errors:
    """Branch 1.0, on 192 x 640 pixels."""
    network = StereoRcnnNetwork(StereoRcnnConfiguration.preset("resnet101")).eval()
    fill_by_rule(network)
    for key, tensor in network.state_dict().items():
        if key.endswith("bn3.weight"):
            tensor.mul_(0.1)
        if key.startswith(("RCNN_rpn.RPN_bbox", "RCNN_bbox_pred")):
            tensor.mul_(0.01)
    left, right = random_pair(192, 640)
    output = network(left, right)
    proposals, boxes, keypoints = output.proposals, output.boxes, output.keypoints
    borders = keypoints.border_logits[0].softmax(-1)
    rows = {
        "rois_l": functional.pad(proposals.left[0], (1, 0)),  # before the box, its image: 0
        "rois_r": functional.pad(proposals.right[0], (1, 0)),
        "cls": boxes.class_probabilities[0],
        "bbox": boxes.box_deltas[0].flatten(1),
        "dim": boxes.dimensions_orientation[0].flatten(1),
        "kpts": keypoints.corner_logits[0].softmax(-1),
        "lb": borders[:, 0],
        "rb": borders[:, 1],
    }
    path = folder / "stereo_rcnn10_192x640.npz"
    rows = in_reference_order(rows, proposals.scores[0], path)
    return {
        "parameters": count_error(network, 105_891_446),
        **against_reference({"c5": network.stages(left)[-1]}, path),
        **against_reference(rows, path),
    }


def pixor(folder: Path) -> Errors:
    """On a grid of 800 x 700 cells, three in a hundred of them occupied."""
    network = PixorNetwork(PixorConfiguration.preset("default")).eval()
    fill_by_rule(network)
    generator = torch.Generator().manual_seed(7)
    output = network((torch.rand(1, 36, 800, 700, generator=generator) > 0.97).float())
    outputs = {"cls": output.scores[:, None], "reg": output.values}
    errors = against_reference(outputs, folder / "pixor_800x700.npz")
    return {"parameters": count_error(network, 2_134_667), **errors}


NETWORKS: dict[str, Callable[[Path], Errors]] = {
    "psmnet": psmnet,
    "dsgn": dsgn("default", "config_car_256x512_ac1.npz", 17_262_958, True),
    "dsgn_12g": dsgn("12g", "config_car_12g_256x512_ac1.npz", 8_054_422, True),
    "dsgn_12g_edges": dsgn("12g", "config_car_12g_256x512_ac0.npz", 8_054_422, False),
    "stereo_rcnn": stereo_rcnn,
    "pixor": pixor,
}
"""Each by its name in the output; a further network adds its function here."""


@torch.no_grad()
def fill_by_rule(network: nn.Module) -> None:
    """Draw every floating tensor from a generator that its key seeds."""
    for key, tensor in network.state_dict().items():
        if not tensor.is_floating_point():
            continue
        generator = torch.Generator().manual_seed(zlib.crc32(key.encode()))
        if key.endswith("running_var"):
            values = 1 + 0.1 * torch.rand(tensor.shape, generator=generator)
        elif tensor.dim() >= 2:
            scale = (0.5 / tensor[0].numel()) ** 0.5
            values = torch.randn(tensor.shape, generator=generator) * scale
        else:
            mean = 1.0 if key.endswith("weight") else 0.0
            values = mean + 0.1 * torch.randn(tensor.shape, generator=generator)
        tensor.copy_(values)


def random_pair(height: int, width: int) -> tuple[Tensor, Tensor]:
    """The inputs of every reference: a left, then a right image of noise, (1, 3, H, W)."""
    generator = torch.Generator().manual_seed(7)
    left = torch.randn(1, 3, height, width, generator=generator)
    return left, torch.randn(1, 3, height, width, generator=generator)


def against_reference(outputs: dict[str, Tensor], path: Path) -> Errors:
    """The error of each output against 64 values, mean and deviation in the file."""
    reference = np.load(path)
    errors = {}
    for name, output in outputs.items():
        ours = output.detach().flatten().double().numpy()
        if ours.size != np.prod(reference[f"{name}_shape"]):
            raise ValueError(f"{name} of {path.name} has {ours.size} values")
        expected = reference[f"{name}_val"]
        difference = np.abs(ours[reference[f"{name}_idx"]] - expected).max()
        statistics = np.abs(
            np.array([ours.mean(), ours.std()]) - reference[f"{name}_mean_std"]
        ).max()
        errors[name] = float(max(difference, statistics) / np.abs(expected).max())
    return errors


def in_reference_order(outputs: dict[str, Tensor], scores: Tensor, path: Path) -> dict[str, Tensor]:
    """Rows of regions, neighbours whose scores tie swapped where the reference has them so.

    Args:
        outputs: Shape (N, ...) each; the same rows of all of them are swapped.
        scores: What the regions are sorted by, best first, shape (N,).
        path: The reference.
    """
    order = torch.arange(len(scores))
    error = sum(against_reference(outputs, path).values())
    for upper in (scores[:-1] - scores[1:] < 1e-6).nonzero()[:, 0]:
        swapped = order.clone()
        swapped[upper], swapped[upper + 1] = order[upper + 1], order[upper]
        trial = {name: rows[swapped] for name, rows in outputs.items()}
        if (other := sum(against_reference(trial, path).values())) < error:
            order, error = swapped, other
    return {name: rows[order] for name, rows in outputs.items()}


def count_error(network: nn.Module, expected: int) -> float:
    """How far the number of parameters is from the original's, relative to it; 0 or a failure."""
    count = sum(parameter.numel() for parameter in network.parameters())
    return 0.0 if count == expected else max(abs(count - expected) / expected, 2 * TOLERANCE)


def main() -> int:
    """Compare, print, judge."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="the references")
    parser.add_argument("--json", action="store_true", help="one JSON object, no table")
    parser.add_argument("--only", nargs="+", choices=sorted(NETWORKS), default=list(NETWORKS))
    options = parser.parse_args()
    if not (options.folder / "README.md").is_file():
        parser.error(f"{options.folder} holds no parity references")
    with torch.no_grad():
        results = {name: NETWORKS[name](options.folder) for name in options.only}
    if options.json:
        print(json.dumps(results, indent=1))
    else:
        show(results)
    agree = all(error <= TOLERANCE for errors in results.values() for error in errors.values())
    return 0 if agree else 1


def show(results: dict[str, Errors]) -> None:
    """A table for people."""
    table = Table("network", "output", "error", "", title="Parity with the original networks")
    for network, errors in results.items():
        for output, error in errors.items():
            agreement = "[green]agrees" if error <= TOLERANCE else "[red]differs"
            table.add_row(network, output, f"{error:.1e}", agreement)
    Console().print(table)


if __name__ == "__main__":
    sys.exit(main())
