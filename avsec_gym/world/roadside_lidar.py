"""A fixed LiDAR on a pole beside the road: one more witness of what vehicles scan.

Its head is that of the vehicles, upright, `HEIGHT` above the ground.  The pole is thin and is not
rendered, so that nothing that vehicles measure depends on whether there is one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.capture import Lidar, Scan, Sweep
from avsec_gym.world.drives import DriveWorld
from avsec_gym.world.motion import bodies_near
from avsec_gym.world.posed_scenes import PosedScene
from avsec_gym.world.rendering.relief import draw_relief

HEIGHT = 5.0
"""Metres above the ground: as high as street lamps hang lights over a pavement, and above vans."""
_BESIDE = 0.8
"""Metres from the edge of what is driven on."""
_ALONG = np.arange(-20.0, 21.0, 2.0)
"""Places that are tried, metres along the road from the middle of the sensor vehicles."""
_SEED = 14


def roadside_pose(world: DriveWorld) -> Floats:
    """Where the LiDAR of a drive is, from its velodyne frame to the world, shape (4, 4).

    Of the places beside the road it is that which is farthest from all scenery: there, least of the
    view is hidden.  The same for all instants of the drive.

    Args:
        world: Place and traffic of the drive.
    """
    site, places = world.site, world.ego_poses[..., :2, 3].reshape(-1, 2)
    along, _ = site.course.coordinates(places[:, 0], places[:, 1])
    right, left = site.section.carriageway
    tried = np.concatenate(
        [
            site.course.poses(along.mean() + _ALONG, np.full(len(_ALONG), beside))
            for beside in (right - _BESIDE, left + _BESIDE)
        ]
    )
    free = [world.built.clearance(x, y) for x, y in tried[:, :2].tolist()]
    x, y, heading = tried[int(np.argmax(free))].tolist()
    pose = np.eye(4)
    cos, sin = np.cos(heading), np.sin(heading)
    pose[:2, :2] = [[cos, -sin], [sin, cos]]
    pose[:3, 3] = x, y, float(site.ground.height(x, y)) + HEIGHT
    return pose


def roadside_scan(posed: PosedScene, pose: Floats, lidar: Lidar, sweep: Sweep) -> Scan:
    """The scan of a fixed LiDAR, which no vehicle's body hides anything from.

    Args:
        posed: The scene at the time of the scan.
        pose: From its velodyne frame to the world, shape (4, 4).
        lidar: The LiDAR; without a seed, it is a device of its own, the same over a drive.
        sweep: Whether other things move while it turns.
    """
    if lidar.seed is None:
        device = np.random.SeedSequence((*posed.seed[:2], _SEED))
        lidar = replace(lidar, seed=int(device.generate_state(1)[0]))
    heading = float(np.arctan2(pose[1, 0], pose[0, 0]))
    place = (float(pose[0, 3]), float(pose[1, 3]), heading)
    instant = posed.instant
    return lidar.scan(
        posed.built.renderer_from(place, instant.actors, instant.egos),
        pose,
        np.random.Generator(np.random.PCG64(np.random.SeedSequence((*posed.seed, _SEED)))),
        bodies=() if sweep is Sweep.INSTANT else bodies_near(instant, *place[:2]),
        relief=draw_relief(posed.site.seed),
    )
