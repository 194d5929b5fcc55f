"""The traffic around the car on highway-env's road: actors come, play or react, and go."""

from __future__ import annotations

import numpy as np
from highway_env.road.road import Road
from numpy.typing import NDArray

from avsec_gym.closed_loop.reacting import Reacting
from avsec_gym.closed_loop.surroundings import ActorStates, Surroundings
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.closed_loop.vehicles import ReactingVehicle, RecordedVehicle
from avsec_gym.geometry import Floats
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import EgoState

_SLOWEST = 1.0
"""m/s: slower vehicles are not taken for drivers."""
_VEHICLES = ("Car", "Van", "Truck", "Misc")


class RoadTraffic:
    """All actors of a scene on a road, in the order of its tracks.

    Args:
        scene: The scene.
        road: highway-env's road, on which the actors are put.
        reacting: Which of them are driven by highway-env's IDM; the others play their tracks.
    """

    def __init__(self, scene: TrafficScene, road: Road, reacting: Reacting = Reacting()) -> None:
        self.scene, self.road, self._time = scene, road, scene.sets_off
        tracks = scene.tracks
        chosen = frozenset[int]()
        if not reacting.is_recorded:
            drivers = [i for i in range(len(tracks)) if self._drives(i)]
            chosen = reacting.chosen(scene.id, tracks.ids[drivers])
        self.actors = [
            (ReactingVehicle if id in chosen else RecordedVehicle)(tracks, i, road, self._time)
            for i, id in enumerate(tracks.ids.tolist())
        ]
        self._reacts = np.array([isinstance(each, ReactingVehicle) for each in self.actors], bool)
        self._others = list(road.vehicles)
        self.show(0.0)

    def _drives(self, actor: int) -> bool:
        """Whether an actor drives in a lane at the start, so that a driver can take it over."""
        tracks, lanes = self.scene.tracks, self.scene.lanes
        if not tracks.present(actor, self._time):
            return False
        x, y, heading, speed = tracks.state(actor, self._time)
        if str(tracks.categories[actor]) not in _VEHICLES or speed < _SLOWEST:
            return False
        return lanes.followed(x, y, heading) is not None

    def show(self, elapsed: float) -> None:
        """Bring on those that are there, and take away the others.

        Args:
            elapsed: Seconds since the start of the drive.
        """
        time = self._time + elapsed
        tracks = self.scene.tracks
        steps = time / 0.1
        there = (tracks.first - 1e-6 <= steps) & (steps <= tracks.last + 1e-6)
        self.present: NDArray[np.bool_] = there | self._reacts
        self.road.vehicles = self._others + [
            actor for actor, here in zip(self.actors, self.present, strict=True) if here
        ]

    def step_absent(self, dt: float) -> None:
        """Let the clocks of those run on that are not on the road."""
        for actor, here in zip(self.actors, self.present, strict=True):
            if not here:
                actor.step(dt)

    def poses(self) -> Floats:
        """x, y, heading of all actors in this project's plane, shape (N, 3)."""
        if not self.actors:
            return np.zeros((0, 3))
        return np.array([(a.position[0], -a.position[1], -a.heading) for a in self.actors])

    def speeds(self) -> Floats:
        """Speeds along the headings, m/s, shape (N,)."""
        return np.array([float(actor.speed) for actor in self.actors])

    @property
    def sizes(self) -> Floats:
        """Length and width of all actors, shape (N, 2)."""
        return self.scene.tracks.dimensions[:, [2, 1]]

    def around(self, state: EgoState, elapsed: float, intention: Intention) -> Surroundings:
        """The truth at this instant, as it lies around a car.

        Args:
            state: The car's state.
            elapsed: Seconds since the start of the drive.
            intention: Where the car wants to go.
        """
        actors = ActorStates(self.poses(), self.speeds(), self.present)
        return actors.around(self.scene, state, elapsed, intention)
