"""Writes down a drive while it goes on, and finds out when it is over."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely

from avsec_gym.closed_loop.drive_log import DriveLog, touched
from avsec_gym.closed_loop.drive_record import (
    DriveRecord,
    Outcome,
    goal_distance,
    outcome_of_time,
    reaches_goal,
    record_of,
)
from avsec_gym.closed_loop.traffic import RoadTraffic
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import EgoState


class DriveRecorder:
    """The record of one drive.

    Args:
        traffic: The traffic, and with it the scene; it is read at every instant.
        intention: Where the car wants to go.
        start: The car's state at the start.
        dt: Seconds between two instants.
        duration: Seconds that the drive may take.
    """

    def __init__(
        self,
        traffic: RoadTraffic,
        intention: Intention,
        start: EgoState,
        *,
        dt: float,
        duration: float,
    ) -> None:
        self.goal_distance = goal_distance(traffic.scene, duration)
        """How far along the road the goal lies, metres."""
        self.outcome: Outcome | None = None
        """How the drive ended; None: it goes on."""
        self.record: DriveRecord | None = None
        """Its metrics, once `close` has seen its end."""
        self.path_length = 0.0
        """Metres driven so far."""
        self._traffic, self._intention = traffic, intention
        self._dt, self._duration = dt, duration
        self._line = traffic.scene.lanes.line(traffic.scene.start_lane)
        self._rows: list[tuple[Any, ...]] = []
        self._write(start)
        # What the car touches from the start on is no collision: labels are centimetres off.
        self._excused = touched(*self._instant())

    def note(self, state: EgoState) -> None:
        """Write down where everything is, and whether the drive is over by that.

        Args:
            state: The car's state at this instant, `dt` after the last one.
        """
        self._write(state)
        scene = self._traffic.scene
        car, *actors = self._instant()
        touching = touched(car, *actors)
        pose = (car[0], car[1], car[3])
        if (touching & ~self._excused).any():
            self.outcome = Outcome.COLLISION
        elif not shapely.contains_xy(scene.drivable, car[0], car[1]):
            self.outcome = Outcome.OFF_ROAD
        elif reaches_goal(scene, self._intention, pose, self.goal_distance):
            self.outcome = Outcome.GOAL
        self._excused &= touching

    def close(self, elapsed: float, *, handed_over: bool = False) -> None:
        """End the drive if its time is over, and measure it if it has ended.

        Args:
            elapsed: Seconds since the start of the drive.
            handed_over: Whether a human has taken over, which ends it, too.
        """
        if self.outcome is None and (handed_over or elapsed >= self._duration - 1e-9):
            self.outcome = outcome_of_time(self.log())
        if self.outcome is not None and self.record is None:
            self.record = record_of(
                self.log(), self._traffic.scene, self._intention, self.outcome, self._duration
            )

    def progress(self, state: EgoState) -> float:
        """Metres along the road from the start to a state of the car."""
        start = self._traffic.scene.start
        begun, _ = self._line.coordinates(start.x, start.y)
        return self._line.coordinates(state.x, state.y)[0] - begun

    def log(self) -> DriveLog:
        """What happened so far."""
        cars, poses, speeds, present = zip(*self._rows, strict=True)
        return DriveLog(
            dt=self._dt,
            car=np.array(cars),
            sizes=self._traffic.sizes,
            poses=np.array(poses),
            speeds=np.array(speeds),
            present=np.array(present),
        )

    def _write(self, state: EgoState) -> None:
        car = (state.x, state.y, state.velocity, state.heading, state.steering_angle)
        traffic = self._traffic
        if self._rows:
            before = self._rows[-1][0]
            self.path_length += math.hypot(car[0] - before[0], car[1] - before[1])
        self._rows.append((car, traffic.poses(), traffic.speeds(), traffic.present.copy()))

    def _instant(self) -> tuple[Any, ...]:
        """The last instant: the car, sizes and poses of the actors, and who of them is there."""
        car, poses, _, present = self._rows[-1]
        return np.array(car), self._traffic.sizes, poses, present
