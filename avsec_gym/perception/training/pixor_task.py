"""The task of PIXOR: cars in labelled LiDAR scans, judged from above on other frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from avsec_gym.perception.detectors.pixor.bird_eye_input import bird_eye_input
from avsec_gym.perception.detectors.pixor.detector import PixorDetector
from avsec_gym.perception.detectors.pixor.losses import pixor_losses
from avsec_gym.perception.detectors.pixor.targets import PixorTargets, cell_targets
from avsec_gym.perception.training.cloud_samples import (
    CloudSample,
    CloudSamples,
    prepare_cloud_samples,
)
from avsec_gym.perception.training.labelled_frames import DataFrames
from avsec_gym.perception.training.scan_task import ScanTask, scan_samples
from avsec_gym.perception.training.scan_variation import varied
from avsec_gym.perception.training.tasks import TaskOptions


@dataclass(frozen=True, eq=False)
class PixorBatch:
    """Scans with the truth.

    Args:
        scans: The scans, shape (B, channels, rows, columns).
        targets: The targets of each.
    """

    scans: Tensor
    targets: PixorTargets

    def to(self, device: torch.device | str) -> PixorBatch:
        """The batch on another device."""
        return PixorBatch(self.scans.to(device), self.targets.to(device))


class PixorTask(ScanTask[PixorDetector, CloudSamples]):
    """A `Task`: scans cropped to the network's region, cars judged from above."""

    view, largest_turn = "bev", 0.2

    def batch(self, indices: Sequence[int], randomness: np.random.Generator) -> PixorBatch:
        """See `Task`."""
        samples = [
            varied(self._training[index], self._augmentation, self.largest_turn, randomness)
            for index in indices
        ]
        return self.batch_of(samples)

    def batch_of(self, samples: Sequence[CloudSample]) -> PixorBatch:
        """Samples as they are."""
        configuration = self._detector.configuration
        scans = [bird_eye_input(scan.points, configuration.region) for scan in samples]
        targets = [
            cell_targets(
                scan.rectangles, configuration, ignored=scan.ignored, azimuths=scan.azimuths
            )
            for scan in samples
        ]
        return PixorBatch(torch.from_numpy(np.stack(scans)), PixorTargets.concatenate(targets))

    def losses(self, batch: PixorBatch) -> dict[str, Tensor]:
        """See `Task`."""
        return pixor_losses(self.network(batch.scans), batch.targets, self._detector.configuration)

    def validate(self) -> dict[str, float]:
        """See `precision`."""
        samples = self._validation
        found = [self._detector.detect(samples.frame(index)) for index in range(len(samples))]
        return {
            **self.precision(found),
            "detections_per_frame": float(np.mean([len(boxes) for boxes in found])),
        }


def pixor_task(options: TaskOptions) -> PixorTask:
    """PIXOR; see `make_task`."""
    torch.manual_seed(options.seed)
    detector = PixorDetector(options.preset)
    seen = detector.configuration.region, detector.configuration.category

    def prepare(frames: Sequence[DataFrames]) -> CloudSamples:
        return prepare_cloud_samples(frames, *seen, options.cache, on_progress=options.on_progress)

    return PixorTask(detector, *scan_samples(options, detector.network, prepare))
