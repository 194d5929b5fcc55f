"""Four vehicles and a base station, a process each, on bad lines: whose LiDAR has a ghost?

    python examples/connected_sockets.py [--lost 0.1] [--late 0.1] [--doubled 0.2] [--malformed 0.1]
    python examples/connected_sockets.py --seconds 10   # on a slow machine

Prints a line for each instant: who was heard, and who is named at the ghost of vehicle 1.
"""

from __future__ import annotations

from multiprocessing import get_context

import numpy as np
import tyro

from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.sweep import TIP
from avsec_gym.validation.connected.transport.exchange import judge_instant, take_part
from avsec_gym.validation.connected.transport.station_port import StationPort
from avsec_gym.validation.connected.transport.vehicle_port import Faults, VehiclePort
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from avsec_gym.world.capture import Lidar
from avsec_gym.world.rendering.ray_scene import RayScene, Thing
from avsec_gym.world.shapes import box, polygon
from avsec_gym.world.site import Surface

INSTANTS = 5
CARS, GHOST = ((14, 3, 0.1), (24, -7, 0.4)), (15, -4, -0.2)
PLACES = ((0, 0, 0), (30, 2, np.pi), (14, -14, np.pi / 2), (22, 12, -2.0))


def scan_of(vehicle: int) -> VehicleScan:
    """What a vehicle's LiDAR measures on a plain with two cars, and with the ghost if it is 1."""
    x, y, heading = PLACES[vehicle]
    cos, sin = np.cos(heading), np.sin(heading)
    pose = np.array([[cos, -sin, 0, x], [sin, cos, 0, y], [0, 0, 1, 1.73], [0, 0, 0, 1]])
    cars = [*CARS, GHOST] if vehicle == 1 else CARS
    plain = polygon([(-99, -99, 0), (99, -99, 0), (99, 99, 0), (-99, 99, 0)])
    meshes = [plain, *(box(4.2, 1.8, 1.5).placed(a, b, 0, yaw) for a, b, yaw in cars)]
    rays = Lidar().directions
    origin = np.tile(np.float32(pose[:3, 3] + [0, 0, TIP]), (len(rays), 1))
    scene = RayScene([Thing(mesh, Surface.ROAD) for mesh in meshes])
    far = scene.hits(origin, np.ascontiguousarray(rays @ pose[:3, :3].T, np.float32)).distance
    points = (rays * far[:, None] + [0, 0, TIP])[far < 80]
    return VehicleScan(np.c_[points, np.full(len(points), 0.3)].astype(np.float32), pose)


def drive(port: int, faults: Faults, seed: int) -> None:
    """A vehicle's process: it takes part in each instant."""
    line = VehiclePort(port, faults, seed)
    margins = read_connected_fit(SHIPPED_FIT).margins
    for instant in range(INSTANTS):
        scan = scan_of(line.number)
        take_part(line, instant, scan, ClusterProposer(), seconds=30, margins=margins)
    line.receive(30)  # Until the base station leaves.


def main(faults: Faults, seconds: float = 3.0) -> None:
    """The base station's process, which starts the others.

    Args:
        faults: Shares of messages with which something happens.
        seconds: How long it waits for what is missing, at each step.
    """
    with StationPort(len(PLACES)) as station:
        for seed in range(len(PLACES)):
            process = get_context("spawn").Process
            process(target=drive, args=(station.number, faults, seed), daemon=True).start()
        station.join(60)
        constants = read_connected_fit(SHIPPED_FIT).constants()
        for instant in range(INSTANTS):
            outcome = judge_instant(station, instant, seconds, constants)
            there = np.hypot(*(outcome.regions.centre[:, :2] - GHOST[:2]).T) < 1.5
            print(f"{instant}: heard {outcome.heard}, named at the ghost {outcome.named[there]}")
        print(f"left out: {dict(station.tally)}")


if __name__ == "__main__":
    tyro.cli(main, config=(tyro.conf.OmitArgPrefixes,))
