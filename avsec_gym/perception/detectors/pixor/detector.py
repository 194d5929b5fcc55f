"""`PixorDetector`: the network between a LiDAR scan and KITTI's boxes."""

from __future__ import annotations

import torch

from avsec_gym.argument_checks import instance_or_none
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.network_detector import NetworkDetector
from avsec_gym.perception.detectors.pixor.bird_eye_input import bird_eye_input
from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration
from avsec_gym.perception.detectors.pixor.decoding import PixorDecodingRule, found_rectangles
from avsec_gym.perception.detectors.pixor.network import PixorNetwork
from avsec_gym.perception.detectors.pixor.upright_boxes import ground_heights, upright_boxes
from avsec_gym.perception.presets import chosen_configuration
from avsec_gym.perception.weights.given import Weights

_SMALL_RULE = PixorDecodingRule(candidates=512)
"""A near car has fifty cells: 64 may all be of the surest two."""


class PixorDetector(NetworkDetector[PixorConfiguration, PixorNetwork]):
    """Finds cars in the scan alone; images serve only to clip 2D boxes.

    A box stands on the ground that the scan shows around it and has the height of its class: from
    above, neither is seen.  Its `network` stands in evaluation mode and its weights are frozen;
    training thaws it.

    Args:
        configuration: The configuration of the network, or a preset's name.
        weights: A file, a ``state_dict``, ``shipped``, or None for random ones; see `give_weights`.
        rule: The rule by which cells become boxes; None: as published, but for the small one, with
            more candidates.

    Raises:
        ConfigurationError: The weights are those of another configuration.
        DataError: Their file is missing or damaged.
    """

    name = "pixor"

    def __init__(
        self,
        configuration: PixorConfiguration | str = "small",
        weights: Weights = None,
        rule: PixorDecodingRule | None = None,
    ) -> None:
        given_rule = instance_or_none("rule", rule, PixorDecodingRule)
        configuration, preset = chosen_configuration(PixorConfiguration, configuration)
        super().__init__(configuration, PixorNetwork, weights, preset)
        published = configuration == PixorConfiguration.preset("default")
        self.rule = given_rule or (PixorDecodingRule() if published else _SMALL_RULE)

    def propose(self, frame: SensorFrame) -> Boxes3D:
        """Where cars may be, as regions of connected vehicles; see `detect`.

        Turned to one sector after the other, the network looks all around
        (`avsec_gym.validation.connected.proposals.sectors.SectorProposer`).
        """
        return self.detect(frame)

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The objects of a frame, best score first, with `alpha`.

        Where camera 2 is calibrated, with `box2d`; where there is its image, without what it does
        not show.

        Raises:
            DataError: The frame has no LiDAR scan, or one without points.
        """
        points = frame.points
        if not len(points):
            raise DataError(
                f"The LiDAR scan of frame {frame.id} has no points.",
                path=frame.origin,
                remedy="Without returns nothing can be said of what is there.",
            )
        scan = torch.from_numpy(bird_eye_input(points, self.configuration.region))[None]
        with torch.no_grad():
            output = self.network(scan.to(next(self.network.parameters())))
        [(rectangles, scores)] = found_rectangles(output, self.configuration, self.rule)
        size = frame.image(2).shape[:2] if 2 in frame.images else None
        return upright_boxes(
            rectangles,
            ground_heights(points, rectangles),
            self.calibration(scores),
            self.configuration.category,
            self.configuration.object_height,
            frame.calibration,
            size,
        )
