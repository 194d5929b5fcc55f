"""The task of PointRCNN: cars among the points of labelled scans, both stages at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.detectors.pointrcnn.detector import PointRcnnDetector
from avsec_gym.perception.detectors.pointrcnn.losses import pointrcnn_losses
from avsec_gym.perception.detectors.pointrcnn.points_input import sampled_points
from avsec_gym.perception.detectors.pointrcnn.proposals import overlaps
from avsec_gym.perception.training.labelled_frames import DataFrames
from avsec_gym.perception.training.point_samples import PointSamples, prepare_point_samples
from avsec_gym.perception.training.scan_task import ScanTask, scan_samples
from avsec_gym.perception.training.scan_variation import varied
from avsec_gym.perception.training.tasks import TaskOptions


@dataclass(frozen=True, eq=False)
class PointBatch:
    """Scans with the truth.

    Args:
        points: Camera frame, shape (B, N, 3).
        objects: The objects of each scan, (M, 7).
        ignored: The ignored objects of each scan, (K, 7).
    """

    points: Tensor
    objects: list[Tensor]
    ignored: list[Tensor]

    def to(self, device: torch.device | str) -> PointBatch:
        """The batch on another device."""
        objects, ignored = (
            [boxes.to(device) for boxes in each] for each in (self.objects, self.ignored)
        )
        return PointBatch(self.points.to(device), objects, ignored)


class PointRcnnTask(ScanTask[PointRcnnDetector, PointSamples]):
    """A `Task`: points in view, as many as the network takes, cars judged in 3D."""

    view, largest_turn = "3d", np.pi / 18  # As published.

    def batch(self, indices: Sequence[int], randomness: np.random.Generator) -> PointBatch:
        """See `Task`."""
        view = self._detector.configuration.view
        points, objects, ignored = [], [], []
        for index in indices:
            sample = self._training[index]
            one = varied(sample, self._augmentation, self.largest_turn, randomness)
            points.append(torch.from_numpy(sampled_points(one.points, view, randomness)))
            objects.append(torch.from_numpy(one.objects).float())
            ignored.append(torch.from_numpy(one.ignored).float())
        return PointBatch(torch.stack(points), objects, ignored)

    def losses(self, batch: PointBatch) -> dict[str, Tensor]:
        """See `Task`."""
        network = self._detector.network
        return pointrcnn_losses(network, batch.points, batch.objects, batch.ignored)

    def validate(self) -> dict[str, float]:
        """See `precision`; ``proposal_recall``: of objects that a proposal overlaps by half."""
        samples = self._validation
        stages = [self._detector.both_stages(samples.frame(i)) for i in range(len(samples))]
        proposed, found = zip(*stages, strict=True)
        return {
            **self.precision(found),
            "proposal_recall": self._recall(proposed),
            "detections_per_frame": float(np.mean([len(boxes) for boxes in found])),
        }

    def _recall(self, proposed: Sequence[Boxes3D]) -> float:
        """Share of the objects that can be found and that a proposal overlaps by half."""
        hits: list[bool] = []
        for index, boxes in enumerate(proposed):
            objects = torch.from_numpy(self._validation[index].objects)
            rows = np.column_stack([boxes.location, boxes.dimensions, boxes.rotation_y])
            shared = overlaps(objects, torch.from_numpy(rows))
            hits += (shared >= 0.5).any(1).tolist()
        return float(np.mean(hits)) if hits else 0.0


def pointrcnn_task(options: TaskOptions) -> PointRcnnTask:
    """PointRCNN; see `make_task`."""
    torch.manual_seed(options.seed)
    detector = PointRcnnDetector(options.preset)

    def prepare(frames: Sequence[DataFrames]) -> PointSamples:
        return prepare_point_samples(
            frames, detector.configuration, options.cache, on_progress=options.on_progress
        )

    return PointRcnnTask(detector, *scan_samples(options, detector.network, prepare))
