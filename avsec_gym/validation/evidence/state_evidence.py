"""The evidence in every sensor state vector; each disparity map is found once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from itertools import product

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Points, SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityError, DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps, PairView
from avsec_gym.validation.evidence.evidence import gather_evidence
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.state_posterior import States

SensorStates = tuple[tuple[int, ...], tuple[bool, ...]]
"""Positions of sensors, and which of them are attacked."""


class StateEvidence:
    """One frame in any state **s**, of the 2^(n+1) that there are.

    A map depends on the states of its two sensors alone, an error on those of three.  With one
    LiDAR and three cameras, the 16 states take 12 matchings, not 48.

    Args:
        clean: The frame without an attack.
        tampered: The frame with one sensor attacked, for each that can be; what
            other sensors deliver in it does not count.
        system: The sensors.
        depth: How disparities of two cameras are found.

    Raises:
        ConfigurationError: The cameras do not stand from right to left.
    """

    def __init__(
        self,
        clean: SensorFrame,
        tampered: Mapping[Sensor, SensorFrame],
        system: SensorSystem,
        depth: PairDepth | None = None,
    ) -> None:
        system.check(clean.calibration)
        self.system, self.depth = system, depth or PairDepth()
        self._clean, self._tampered = clean, dict(tampered)
        self._views: dict[SensorStates, PairView] = {}
        self._errors: dict[SensorStates, DisparityError] = {}

    def otherwise(self, tampered: Mapping[Sensor, SensorFrame]) -> StateEvidence:
        """The same frame attacked otherwise; what is known of sound sensors stays known."""
        other = StateEvidence(self._clean, tampered, self.system, self.depth)
        other._views = {
            element: view for element, view in self._views.items() if not any(element[1])
        }
        other._errors = {
            element: error for element, error in self._errors.items() if not any(element[1])
        }
        return other

    def with_scan(self, points: Points) -> StateEvidence:
        """The same frame with another clean scan, its LiDAR not attacked.

        What is known of cameras alone stays known, attacked or not.
        """
        tampered = {sensor: frame for sensor, frame in self._tampered.items() if sensor != LIDAR}
        other = StateEvidence(self._clean.with_points(points), tampered, self.system, self.depth)
        other._views = {
            element: view
            for element, view in self._views.items()
            if not self.system.has_scan(element[0])
        }
        other._errors = {
            element: error
            for element, error in self._errors.items()
            if not self.system.has_scan(element[0])
        }
        return other

    def attacked_too(self, sensor: Sensor, tampered: SensorFrame) -> StateEvidence:
        """The same attacks, and one on a sensor that was not attacked; all stays known.

        Raises:
            ConfigurationError: There is an attack on that sensor already.
        """
        if sensor in self._tampered:
            raise ConfigurationError(f"an attack on the sensor {sensor!r} is given already")
        attacks = {**self._tampered, sensor: tampered}
        other = StateEvidence(self._clean, attacks, self.system, self.depth)
        other._views, other._errors = dict(self._views), dict(self._errors)
        return other

    def find(self, states: States, threads: int = 2) -> None:
        """Find all maps that these states need at once.

        Args:
            states: The states, shape (N, n + 1).
            threads: OpenCV's matching runs outside Python's lock.
        """
        wanted = {
            _element(pair, state)
            for pair, state in product(self.system.pairs(), np.atleast_2d(states))
        }
        missing = sorted(wanted - self._views.keys())
        with ThreadPoolExecutor(threads) as pool:
            self._views.update(zip(missing, pool.map(self._find, missing), strict=True))

    def evidence(self, states: States) -> Floats:
        """The evidence that `gather_evidence` finds in each state, shape (N, M)."""
        self.find(states)
        return np.array([gather_evidence(self.errors(state)) for state in np.atleast_2d(states)])

    def errors(self, state: States) -> DisparityErrors:
        """E_{i,j,k} of all triples in one state, shape (n + 1,)."""
        self.find(state)
        known = {pair: self._views[_element(pair, state)] for pair in self.system.pairs()}
        frame = self._attacked(self.system.sensors, state)
        errors = DisparityErrors(
            DisparityMaps(frame, self.system, self.depth, known),
            {
                triple: self._errors[element]
                for triple in self.system.triples
                if (element := _element(triple, state)) in self._errors
            },
        )
        self._errors |= {_element(triple, state): errors[triple] for triple in errors}
        return errors

    def _find(self, element: SensorStates) -> PairView:
        pair, attacked = element
        frame = self._attacked([self.system.sensors[position] for position in pair], attacked)
        return DisparityMaps(frame, self.system, self.depth).view((pair[0], pair[1]))

    def _attacked(self, sensors: Iterable[Sensor], state: Iterable[bool]) -> SensorFrame:
        frame = self._clean
        for sensor, is_attacked in zip(sensors, state, strict=True):
            if is_attacked:
                frame = self._with(frame, sensor)
        return frame

    def _with(self, frame: SensorFrame, sensor: Sensor) -> SensorFrame:
        if sensor not in self._tampered:
            raise ConfigurationError(f"no attack on the sensor {sensor!r} is given")
        if isinstance(sensor, int):
            return frame.with_image(sensor, self._tampered[sensor].image(sensor))
        return frame.with_points(self._tampered[sensor].points)


def _element(positions: tuple[int, ...], state: Iterable[bool]) -> SensorStates:
    attacked = list(state)
    return positions, tuple(bool(attacked[position]) for position in positions)
