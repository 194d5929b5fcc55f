"""`RememberedProposals`: regions of scans that come again are found once."""

from __future__ import annotations

from collections import OrderedDict

from avsec_gym.argument_checks import whole_number
from avsec_gym.frame import Points
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.regions import Regions


class RememberedProposals:
    """Proposals by clusters of scans that come again: those of the vehicles that are not attacked.

    A scan is known by its points, whichever array they are in.

    Args:
        most: Number of scans that are remembered, the last ones.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    def __init__(self, most: int = 24) -> None:
        self._most, self._propose = whole_number("most", most, 1), ClusterProposer()
        self._known: OrderedDict[int, tuple[Points, Regions]] = OrderedDict()

    def __call__(self, points: Points) -> Regions:
        """See `RegionProposer`."""
        key = hash((points.shape, points[:: max(1, len(points) // 512)].tobytes()))
        if key in self._known and (self._known[key][0] == points).all():
            return self._known[key][1]
        regions = self._propose(points)
        self._known[key] = points, regions
        if len(self._known) > self._most:
            self._known.popitem(last=False)
        return regions
