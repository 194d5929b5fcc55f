"""`PointRcnnDetector`: the network between a LiDAR scan and KITTI's boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from avsec_gym.argument_checks import instance_or_none
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.perception.detectors.boxes_in_view import boxes_in_view
from avsec_gym.perception.detectors.network_detector import NetworkDetector
from avsec_gym.perception.detectors.pointrcnn.configuration import PointRcnnConfiguration
from avsec_gym.perception.detectors.pointrcnn.network import PointRcnnNetwork
from avsec_gym.perception.detectors.pointrcnn.points_input import points_in_view, sampled_points
from avsec_gym.perception.detectors.pointrcnn.proposals import (
    ScanProposals,
    from_above,
    refined_boxes,
)
from avsec_gym.perception.nn.rotated_nms import rotated_nms
from avsec_gym.perception.presets import chosen_configuration
from avsec_gym.perception.weights.given import Weights


@dataclass(frozen=True)
class PointRcnnDecodingRule:
    """Which refined boxes become objects; the defaults are those of the public code."""

    least_score: float = 0.3
    most_overlap: float = 0.1
    """Intersection over union, from above, of two boxes that may both stay."""

    def __post_init__(self) -> None:
        if not (0 <= self.least_score < 1 and 0 <= self.most_overlap <= 1):
            raise ConfigurationError(f"scores and overlaps are shares, got {self}")


_SMALL_RULE = PointRcnnDecodingRule(least_score=0.05)
"""Users choose their own thresholds; average precision asks for all."""


class PointRcnnDetector(NetworkDetector[PointRcnnConfiguration, PointRcnnNetwork]):
    """Finds cars among the points of a scan; the image serves only to know what is in view.

    Which points are looked at, where there are more than the network takes, is drawn by chance,
    the same for the same scan.  Its `network` stands in evaluation mode and its weights are
    frozen; training thaws it.

    Args:
        configuration: The configuration of the network, or a preset's name.
        weights: A file, a ``state_dict``, ``shipped``, or None for random ones; see `give_weights`.
        rule: The rule by which boxes are reported; None: as published, but for the small
            one, also unsure ones.

    Raises:
        ConfigurationError: The weights are those of another configuration.
        DataError: Their file is missing or damaged.
    """

    name = "pointrcnn"

    def __init__(
        self,
        configuration: PointRcnnConfiguration | str = "small",
        weights: Weights = None,
        rule: PointRcnnDecodingRule | None = None,
    ) -> None:
        given_rule = instance_or_none("rule", rule, PointRcnnDecodingRule)
        configuration, preset = chosen_configuration(PointRcnnConfiguration, configuration)
        super().__init__(configuration, PointRcnnNetwork, weights, preset)
        published = configuration == PointRcnnConfiguration.preset("default")
        self.rule = given_rule or (PointRcnnDecodingRule() if published else _SMALL_RULE)

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The objects of a frame, best score first, with `alpha`; the score is the confidence.

        Where camera 2 is calibrated, with `box2d`; where there is its image, without what it does
        not show.

        Raises:
            DataError: The frame has no LiDAR scan, or one without points in view.
        """
        return self.both_stages(frame)[1]

    def propose(self, frame: SensorFrame) -> Boxes3D:
        """The first stage by itself: where objects may be, best score first; otherwise as `detect`.

        These are the validation regions of connected vehicles (thesis, section 4.4.2).

        Raises:
            DataError: The frame has no LiDAR scan, or one without points in view.
        """
        with torch.no_grad():
            [proposed] = self.network.propose(self.network.rpn(self._seen(frame)))
        return self._proposed(proposed, frame)

    def both_stages(self, frame: SensorFrame) -> tuple[Boxes3D, Boxes3D]:
        """What `propose` and what `detect` find, in the time of `detect`."""
        with torch.no_grad():
            output = self.network(self._seen(frame))
        [proposed] = output.proposals
        coding = self.configuration.refinement.coding
        boxes = refined_boxes(proposed.boxes, output.refinement.codes.float(), coding)
        scores = torch.sigmoid(output.refinement.logits.float()).double().cpu().numpy()
        likely = np.flatnonzero(scores > self.rule.least_score)
        kept = rotated_nms(from_above(boxes)[likely], scores[likely], self.rule.most_overlap)
        chosen = likely[kept]
        found = self._boxes(boxes[chosen], self.calibration(scores[chosen]), frame)
        return self._proposed(proposed, frame), found

    def _seen(self, frame: SensorFrame) -> Tensor:
        view = self.configuration.view
        places = points_in_view(frame, view)
        points = torch.from_numpy(sampled_points(places, view))[None]
        return points.to(next(self.network.parameters()))

    def _proposed(self, proposed: ScanProposals, frame: SensorFrame) -> Boxes3D:
        return self._boxes(proposed.boxes, proposed.scores.double().cpu().numpy(), frame)

    def _boxes(self, rows: Tensor, scores: Floats, frame: SensorFrame) -> Boxes3D:
        boxes = rows.double().cpu().numpy()
        return boxes_in_view(
            boxes[:, :3],
            boxes[:, 3:6],
            wrap_angle(boxes[:, 6]),
            scores,
            self.configuration.category,
            frame.calibration,
            frame.image(2).shape[:2] if 2 in frame.images else None,
        )
