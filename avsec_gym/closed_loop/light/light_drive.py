"""One drive as arrays: what `avsec/ClosedLoop-v0` does on highway-env, without its objects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.closed_loop.drive_log import DriveLog, touched
from avsec_gym.closed_loop.drive_record import (
    DriveRecord,
    Outcome,
    goal_distance,
    outcome_of_time,
    record_of,
)
from avsec_gym.closed_loop.light.advance import COLLISION, GOAL, OFF_ROAD, Aim, Reached, advance
from avsec_gym.closed_loop.light.road_table import RoadTable, road_table
from avsec_gym.closed_loop.light.traffic_table import TrafficTable, traffic_table
from avsec_gym.closed_loop.surroundings import ActorStates, Surroundings
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.geometry import Floats
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import EgoState

FREQUENCY = 20
"""Instants a second, as in highway-env."""
DT = 1.0 / FREQUENCY
"""Seconds between two instants."""
HELD = 2
"""Instants that an action is held for: 10 Hz."""
_OUTCOMES = {COLLISION: Outcome.COLLISION, OFF_ROAD: Outcome.OFF_ROAD, GOAL: Outcome.GOAL}


@dataclass(frozen=True, eq=False)
class Place:
    """A scene laid out for any number of drives.

    Args:
        scene: The scene.
        duration: Seconds that a drive may take.
        road: The scene's road.
        traffic: The scene's actors at every instant.
        excused: The actors that the car touches at the start, which is no collision, shape (N,).
    """

    scene: TrafficScene
    duration: float
    road: RoadTable
    traffic: TrafficTable
    excused: NDArray[np.bool_]

    @classmethod
    def of(cls, scene: TrafficScene, duration: float) -> Place:
        """Lay a scene out.

        Args:
            scene: The scene.
            duration: Seconds that a drive may take.
        """
        frames = HELD * (int(duration / (HELD * DT)) + 2)
        traffic = traffic_table(scene, FREQUENCY, frames)
        touching = touched(_row(scene.start), traffic.sizes, traffic.poses[0], traffic.present[0])
        return cls(scene, duration, road_table(scene.lanes), traffic, touching)

    def row(self, lane: int) -> int:
        """The row of a lanelet in the table."""
        return [lanelet.id for lanelet in self.scene.road.lanelets].index(lane)

    def aim(self, intention: Intention) -> Aim:
        """Goal and start of a drive."""
        scene, start = self.scene, self.scene.start
        target = scene.target_lane(intention)
        from_, _ = scene.lanes.line(target).coordinates(start.x, start.y)
        begin, _ = scene.lanes.line(scene.start_lane).coordinates(start.x, start.y)
        distance = goal_distance(scene, self.duration)
        rows = self.row(target), self.row(scene.start_lane)
        return Aim(rows[0], from_, distance, rows[1], begin)


class LightDrive:
    """A drive that goes on action by action.

    Args:
        place: The laid out scene that the car drives in.
        intention: Where the car wants to go.

    Raises:
        ConfigurationError: No lane lies there.
    """

    def __init__(self, place: Place, intention: Intention) -> None:
        self.place, self.intention, self.aim = place, intention, place.aim(intention)
        self.cars: Floats = np.zeros((len(place.traffic.poses), 5))
        """The car's state at every instant: x, y, velocity, heading, steering angle."""
        self.cars[0] = _row(place.scene.start)
        self.reached = Reached(0, 0, 0.0, 0.0, False)
        self.path_length = 0.0
        """Metres driven so far."""
        self.progressed = 0.0
        """Metres along the road that the last action led."""
        self.excused = place.excused.copy()
        """Those of the place that it has touched all along."""
        self.crashed = False
        """As highway-env has it."""
        self.outcome: Outcome | None = None
        """How it ended; None: it goes on."""
        self.record: DriveRecord | None = None
        """Its metrics, once it has ended."""

    @property
    def elapsed(self) -> float:
        """Seconds since the start."""
        return self.reached.frame / FREQUENCY

    @property
    def car(self) -> Floats:
        """The car's present state, shape (5,)."""
        return np.asarray(self.cars[self.reached.frame])

    @property
    def state(self) -> EgoState:
        """The same as the planner takes it."""
        x, y, velocity, heading, steering = self.car.tolist()
        return EgoState(x, y, velocity, heading, steering)

    @property
    def remaining(self) -> tuple[float, float]:
        """Metres to the goal, and the share of the time that is left."""
        left = self.aim.distance - self.reached.progress
        return left, 1.0 - self.elapsed / self.place.duration

    def step(self, acceleration: float, steering: float) -> None:
        """Drive on for a tenth of a second, or until the drive ends.

        Args:
            acceleration: The car's acceleration, m/s2.
            steering: Angle that the wheels turn to, rad, positive to the left.
        """
        place, before = self.place, self.reached
        self.reached = Reached(
            *advance(
                self.cars,
                before.frame,
                HELD,
                acceleration,
                steering,
                DT,
                self.aim,
                self.excused,
                place.road,
                place.traffic,
            )
        )
        self.path_length += self.reached.path
        self.progressed = self.reached.progress - before.progress
        self.outcome = _OUTCOMES.get(self.reached.ending)
        self.crashed |= self.reached.crashed or self.outcome == Outcome.COLLISION
        if self.outcome is None and self.elapsed >= place.duration - 1e-9:
            self.outcome = outcome_of_time(self.log())
        if self.outcome is not None:
            self.record = record_of(
                self.log(), place.scene, self.intention, self.outcome, place.duration
            )

    def surroundings(self) -> Surroundings:
        """The truth at the present instant."""
        traffic, frame = self.place.traffic, self.reached.frame
        actors = ActorStates(traffic.poses[frame], traffic.speeds[frame], traffic.present[frame])
        return actors.around(self.place.scene, self.state, self.elapsed, self.intention)

    def log(self) -> DriveLog:
        """What happened so far."""
        count, traffic = self.reached.frame + 1, self.place.traffic
        return DriveLog(
            dt=DT,
            car=self.cars[:count],
            sizes=traffic.sizes,
            poses=traffic.poses[:count],
            speeds=traffic.speeds[:count],
            present=traffic.present[:count],
        )


def _row(start: EgoState) -> Floats:
    return np.array([start.x, start.y, start.velocity, start.heading, start.steering_angle])
