"""Recovery (section 6.2): what was put into a vehicle's scan is out, what was hidden is back.

Only what a vehicle is named for is changed. A ghost's points go, down to the ground. Of an object
that was removed come back the places that others claim and whose rays no other but the victim
contradicts: centres of voxels, enough for a detector of objects and for a planner, not a scan.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.validation.connected.rays.claims import MARGIN
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

_GROUND = 0.15
"""Metres above a region's bottom up to which points may be the ground's, and stay.  Less than what
is claimed begins at: a stump of 0.35 m of a ghost would still be an obstacle."""


def recovered_scan(scan: VehicleScan, vehicle: int, result: ConnectedResult) -> VehicleScan:
    """A vehicle's scan without the ghosts that it is named for, and with what was removed from it.

    Args:
        scan: The vehicle's scan, as it was judged.
        vehicle: Number of the vehicle.
        result: What was decided by rays of the instant.

    Returns:
        The scan itself where the vehicle is not named. Points that are put back have reflectance 0;
        what moves stands where the others' claims have it at the instant.

    Raises:
        DataError: The result is not one of rays.
    """
    if result.claims is None:
        raise DataError(
            "Scans are recovered from claims, which this result of surfaces does not have.",
            remedy="Validate by the method 'rays'.",
        )
    named = [each for each in result.accusations if each.vehicle == vehicle]
    if not named:
        return scan
    regions, world = result.regions.grown(MARGIN, MARGIN), scan.in_world()
    kept, back = np.ones(len(world), bool), [np.zeros((0, 3))]
    for each in named:
        if each.kind == "ghost":
            raised = world[:, 2] > regions.centre[each.index, 2] + _GROUND
            kept &= ~(regions.contains(each.index, world) & raised)
        else:
            back.append(_hidden_places(each.index, vehicle, result))
    own = transform_points(np.linalg.inv(scan.pose), np.concatenate(back))
    points = np.c_[scan.sweep.rolled(own), np.zeros(len(own))].astype(np.float32)
    return scan.with_points(np.concatenate([scan.points[kept], points]))


def _hidden_places(index: int, victim: int, result: ConnectedResult) -> Floats:
    """Where others claim something in a region that no third vehicle contradicts, shape (P, 3)."""
    assert result.claims is not None
    assert result.counts is not None
    places = [np.zeros((0, 3))]
    for claimer, claims in result.claims.items():
        seen = np.delete(result.counts[index, claimer], victim, axis=0)
        if claimer != victim and not (seen[:, 1] > seen[:, 0]).any():
            places.append(claims[claims.region == index].places(result.regions))
    # Of two that claim the same voxel one is enough.
    return np.unique(np.concatenate(places), axis=0)
