"""What both tasks on LiDAR scans share: samples, and precision in the detector's own view."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any, Generic, Protocol, TypeVar

from torch import nn

from avsec_gym.boxes import Boxes3D
from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.labelled_frames import DataFrames, LabelledFrames
from avsec_gym.perception.training.precision import precision
from avsec_gym.perception.training.scan_samples import NEEDED
from avsec_gym.perception.training.tasks import TaskOptions
from avsec_gym.perception.training.training_data import training_data


class ScanDetector(Protocol):
    """What of a detector is needed here."""

    name: str

    @property
    def network(self) -> nn.Module:
        """What is trained."""
        ...

    @property
    def configuration(self) -> Any:
        """A dataclass with a `category`."""
        ...


_Detector = TypeVar("_Detector", bound=ScanDetector)
Samples = TypeVar("Samples", bound=LabelledFrames)


class ScanTask(Generic[_Detector, Samples]):
    """The part of a `Task` that does not depend on how a network takes its scans.

    Args:
        detector: The detector, whose network is trained in place.
        training: Scans as the network sees them.
        validation: Other scans.
        augmentation: The augmentation of training samples.
        data: JSON-able: what the samples are.
    """

    view: str
    """The view in which the detector is judged first of all."""
    largest_turn: float
    """The largest turn of varied samples, radians."""

    def __init__(
        self,
        detector: _Detector,
        training: Samples,
        validation: Samples,
        augmentation: Augmentation,
        data: dict[str, Any],
    ) -> None:
        self.name = detector.name
        self.network: nn.Module = detector.network.requires_grad_(True)
        self.trained = self.network
        self.leading_metric = f"{detector.configuration.category}_{self.view}_ap40"
        self._detector, self._augmentation, self._data = detector, augmentation, data
        self._training, self._validation = training, validation

    @property
    def samples(self) -> int:
        """See `Task`."""
        return len(self._training)

    def description(self) -> dict[str, Any]:
        """See `Task`."""
        return {
            "network": asdict(self._detector.configuration),
            "augmentation": asdict(self._augmentation) | {"largest_turn": self.largest_turn},
            "data": self._data,
        }

    def precision(self, found: Sequence[Boxes3D]) -> dict[str, float]:
        """Average precision of validation frames (percent, moderate, unless named otherwise).

        ``..._iou50`` stands for the easier thresholds `LOW_IOU`, 0.5 for cars.
        """
        other = "3d" if self.view == "bev" else "bev"
        own = ("ap40", "ap11", "ap11_easy", "ap11_hard", "ap11_iou50")
        measures = (*(f"{self.view}_{measure}" for measure in own), f"{other}_ap11", "2d_ap11")
        category = self._detector.configuration.category
        return precision(self._validation.labels, found, category, measures)


def scan_samples(
    options: TaskOptions,
    network: nn.Module,
    prepare: Callable[[Sequence[DataFrames]], Samples],
) -> tuple[Samples, Samples, Augmentation, dict[str, Any]]:
    """What a `ScanTask` is made of beside its detector.

    Args:
        options: The options of the task.
        network: The network that gets the weights to start with, if there are any.
        prepare: Function that makes samples of frames.

    Raises:
        DataError: There are no data; the command that makes them is named.
    """
    options.begin(network)
    data = training_data(options.data, options.validation, needed=NEEDED)
    training, validation = (prepare(frames) for frames in (data.training, data.validation))
    return training, validation, options.augmentation, data.description()
