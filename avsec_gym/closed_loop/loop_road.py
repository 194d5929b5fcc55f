"""highway-env's road, stepped without asking whether recorded actors touch each other."""

from __future__ import annotations

import math

from highway_env.road.road import Road
from highway_env.vehicle.kinematics import Vehicle
from highway_env.vehicle.objects import RoadObject


class LoopRoad(Road):  # type: ignore[misc]
    """A road of highway-env on which most vehicles play tracks.

    highway-env asks of every pair of vehicles whether they collide.  Of two that check no
    collisions, the answer changes nothing; among 50 recorded actors that is nearly every pair.
    """

    def step(self, dt: float) -> None:
        """Step every vehicle, then look for collisions, in highway-env's order.

        Args:
            dt: Length of the step, seconds.
        """
        for vehicle in self.vehicles:
            vehicle.step(dt)
        checking = [i for i, each in enumerate(self.vehicles) if each.check_collisions]
        for i, vehicle in enumerate(self.vehicles):
            if vehicle.check_collisions:
                others = self.vehicles[i + 1 :]
            else:
                others = [self.vehicles[j] for j in checking if j > i]
            for other in (*others, *self.objects):
                if _near(vehicle, other, dt):
                    vehicle.handle_collisions(other, dt)


def _near(vehicle: Vehicle, other: RoadObject, dt: float) -> bool:
    """Whether two may touch within a time step: what highway-env asks first, ten times slower."""
    reach = (vehicle.diagonal + other.diagonal) / 2 + vehicle.speed * dt
    (x, y), (other_x, other_y) = vehicle.position.tolist(), other.position.tolist()
    return math.hypot(other_x - x, other_y - y) <= reach * (1 + 1e-9)
