"""What the small stereo detectors cost on a CPU: seconds a frame; prints JSON.

    python benchmarks/detectors.py [--threads 2] [--frames 8] [--weights DIR]

`detect` is a whole frame of 1242 x 375 pixels, boxes out; `pixel_gradient` the loss and its
gradient down to the pixels of both images (a step of an attack); `training_per_image` a forward
and a backward pass of two images.  DIR holds ``dsgn.safetensors``, ``dsgn_medium.safetensors`` and
``stereo_rcnn.safetensors``; without it the package's weights count.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors import make_detector
from avsec_gym.perception.stereo_batch import batch_of_frames
from avsec_gym.world.export import world_frames

DETECTORS = {
    "dsgn": {"name": "dsgn"},
    "dsgn_medium": {"name": "dsgn", "configuration": "medium"},
    "stereo_rcnn": {"name": "stereo_rcnn"},
}


def median_seconds(work: Callable[[], Any], runs: int) -> float:
    """Of some runs, after one that does not count."""
    work()
    seconds = []
    for _ in range(runs):
        begun = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - begun)
    return round(statistics.median(seconds), 3)


def measured(
    name: str, frames: list[SensorFrame], labels: list[Boxes3D], weights: Path | None
) -> dict[str, Any]:
    """One detector."""
    given = {"weights": str(weights / f"{name}.safetensors")} if weights else {}
    detector: Any = make_detector(DETECTORS[name] | given)
    every = iter(frames * 2)
    detect = median_seconds(lambda: detector.detect(next(every)), 2 * len(frames) - 1)
    batch = batch_of_frames(frames[:1])
    images = [batch.left.requires_grad_(), batch.right.requires_grad_()]
    attacked = replace(batch, left=images[0], right=images[1])

    def gradient() -> None:
        torch.autograd.grad(sum(detector.losses(attacked, labels[:1]).values()), images)

    pixel_gradient = median_seconds(gradient, 5)
    pair = batch_of_frames(frames[:2]).resized(*detector.configuration.input_size)
    detector.network.train().requires_grad_(True)
    step = median_seconds(lambda: sum(detector.losses(pair, labels[:2]).values()).backward(), 5)
    return {
        "parameters": sum(weight.numel() for weight in detector.network.parameters()),
        "detect": detect,
        "pixel_gradient": pixel_gradient,
        "training_per_image": round(step / 2, 3),
    }


def main() -> None:
    """Measure, print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--weights", type=Path)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    data = world_frames("mixed")
    ids = data.ids()[: options.frames]
    frames, labels = [data.frame(id) for id in ids], [data.labels(id) for id in ids]
    result: dict[str, Any] = {"threads": options.threads, "frames": len(frames)}
    for name in DETECTORS:
        result[name] = measured(name, frames, labels, options.weights)
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
