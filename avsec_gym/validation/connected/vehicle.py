"""What a vehicle does (thesis, sections 4.4.1 and 4.4.2): align, propose, crop, mirror."""

from __future__ import annotations

from collections.abc import Callable

from avsec_gym.frame import Points
from avsec_gym.validation.connected.cropping import CropMargins, cropped, mirrored
from avsec_gym.validation.connected.merging import regions_in_world
from avsec_gym.validation.connected.messages.crop_message import CropMessage
from avsec_gym.validation.connected.messages.region_message import RegionMessage
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

RegionProposer = Callable[[Points], Regions]
"""Where objects may be: a scan, velodyne frame, shape (M, 4), to regions in that frame."""


def propose_regions(number: int, scan: VehicleScan, proposer: RegionProposer) -> RegionMessage:
    """Steps 1 and 2: the vehicle's own proposals, with the transform that aligns them.

    Args:
        number: Number of the vehicle.
        scan: The vehicle's scan, with the pose that it measured.
        proposer: The function that proposes regions all around.
    """
    return RegionMessage(number, scan.pose, proposer(scan.points))


def scan_of_regions(
    number: int,
    scan: VehicleScan,
    complete_set: RegionMessage,
    margins: CropMargins = CropMargins(),
) -> CropMessage:
    """Step 3: the vehicle's scan of every region of the complete set, mirrored.

    Args:
        number: Number of the vehicle.
        scan: The vehicle's scan, with the pose that it measured.
        complete_set: The regions that the base station distributed.
        margins: How much more than a region is cropped.
    """
    regions = regions_in_world(complete_set.regions, complete_set.pose)
    return CropMessage(number, tuple(mirrored(crop) for crop in cropped(scan, regions, margins)))
