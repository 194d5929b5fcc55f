"""highway-env's road, stepped without asking whether recorded actors touch each other."""

from __future__ import annotations

from highway_env.road.road import Road


class LoopRoad(Road):  # type: ignore[misc]
    """A road of highway-env on which most vehicles play tracks.

    highway-env asks of every pair of vehicles whether they collide.  Of two that check no
    collisions, the answer changes nothing; among 50 recorded actors that is nearly every pair.
    """

    def step(self, dt: float) -> None:
        """Step every vehicle, then look for collisions, in highway-env's order.

        Args:
            dt: Seconds.
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
                vehicle.handle_collisions(other, dt)
