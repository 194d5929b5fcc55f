"""PointRCNN's network, with its ``state_dict`` keys: github.com/sshaoshuai/PointRCNN."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor, nn

from avsec_gym.perception.detectors.pointrcnn.configuration import PointRcnnConfiguration
from avsec_gym.perception.detectors.pointrcnn.proposal_network import PointOutput, ProposalNetwork
from avsec_gym.perception.detectors.pointrcnn.proposals import ScanProposals, proposals
from avsec_gym.perception.detectors.pointrcnn.refinement_network import (
    RefinementNetwork,
    RefinementOutput,
    region_points,
)


@dataclass(frozen=True, eq=False)
class PointRcnnOutput:
    """The output of both stages for B scans.

    Args:
        points: The points of the first stage.
        proposals: The proposals of each scan.
        refinement: The refinement of all proposals, one scan after the other.
    """

    points: PointOutput
    proposals: list[ScanProposals]
    refinement: RefinementOutput


class PointRcnnNetwork(nn.Module):
    """Both stages: `rpn` proposes, `rcnn_net` refines."""

    def __init__(self, configuration: PointRcnnConfiguration) -> None:
        super().__init__()
        self.configuration = configuration
        self.rpn = ProposalNetwork(configuration)
        self.rcnn_net = RefinementNetwork(configuration)

    def forward(self, points: Tensor) -> PointRcnnOutput:
        """Detect as in use: points in the camera frame, shape (B, N, 3)."""
        output = self.rpn(points)
        proposed = self.propose(output)
        boxes = [proposals.boxes for proposals in proposed]
        regions = region_points(output, boxes, self.configuration)
        return PointRcnnOutput(output, proposed, self.rcnn_net(regions))

    def propose(self, output: PointOutput) -> list[ScanProposals]:
        """Proposals of each scan, more of them in training."""
        configuration = self.configuration
        rule = configuration.training_proposals if self.training else configuration.proposals
        return proposals(output, configuration.coding, rule)
