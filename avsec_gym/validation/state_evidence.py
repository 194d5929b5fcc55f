"""What the sensors would say in every sensor state vector: each disparity map is found once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import product

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem, Triple
from avsec_gym.validation.disparity_error import DisparityError, disparity_error
from avsec_gym.validation.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence import evidence_shares
from avsec_gym.validation.pair_depth import PairDepth
from avsec_gym.validation.state_posterior import States

Element = tuple[tuple[int, ...], tuple[bool, ...]]
"""Positions of sensors, and which of them are attacked."""


class StateEvidence:
    """One moment in any state **s**, of the 2^(n+1) that there are.

    A map depends on the states of its two sensors alone, an error on those of three.  With one
    LiDAR and three cameras, the 16 states take 12 matchings, not 48.

    Args:
        clean: The moment as it is.
        tampered: For each sensor that can be attacked, the moment with this one attacked; what
            other sensors deliver in it does not count.
        system: Of sensors.
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
        self._maps: dict[Element, tuple[DisparityMap, float]] = {}
        self._errors: dict[Element, DisparityError] = {}

    def find(self, states: States, threads: int = 2) -> None:
        """Find all maps that these states need at once.

        Args:
            states: Shape (N, n + 1).
            threads: OpenCV's matching runs outside Python's lock.
        """
        wanted = {
            (pair, tuple(bool(state[one]) for one in pair))
            for pair, state in product(self.system.pairs(), np.atleast_2d(states))
        } - self._maps.keys()
        missing = sorted(wanted)
        with ThreadPoolExecutor(threads) as pool:
            self._maps.update(zip(missing, pool.map(self._find, missing), strict=True))

    def evidence(self, states: States) -> Floats:
        """As `gather_evidence` of each state, shape (N, M)."""
        self.find(states)
        return np.array([self._evidence(state) for state in np.atleast_2d(states)])

    def errors(self, state: States) -> dict[Triple, DisparityError]:
        """E_{i,j,k} of all triples in one state, shape (n + 1,)."""
        return {triple: self.error(triple, state) for triple in self.system.triples}

    def error(self, triple: Triple, state: Iterable[bool]) -> DisparityError:
        """E_{i,j,k} in one state."""
        attacked = list(state)
        element = (triple, tuple(bool(attacked[one]) for one in triple))
        if element not in self._errors:
            i, j, k = triple
            sparse = self.system.sensors[i] == LIDAR
            (first, one), (second, other) = (self._seen((one, k), attacked) for one in (i, j))
            error = disparity_error(first, second, sparse=sparse)
            self._errors[element] = replace(error, brightness=max(one, other))
        return self._errors[element]

    def _evidence(self, state: States) -> Floats:
        return evidence_shares(
            self.system,
            lambda triple: self.error(triple, state),
            lambda pair: 1.0 - float(self._seen(pair, state)[0].valid.mean()),
            lambda pair: self._seen(pair, state)[1],
        )

    def _seen(self, pair: tuple[int, ...], state: Iterable[bool]) -> tuple[DisparityMap, float]:
        """A map, and the brightness inconsistency of two cameras; 0 with a LiDAR."""
        attacked = list(state)
        element = (pair, tuple(bool(attacked[one]) for one in pair))
        if element not in self._maps:
            self._maps[element] = self._find(element)
        return self._maps[element]

    def _find(self, element: Element) -> tuple[DisparityMap, float]:
        (i, k), attacked = element
        frame = self._clean
        for position, is_attacked in zip((i, k), attacked, strict=True):
            if is_attacked:
                frame = self._with(frame, self.system.sensors[position])
        maps = DisparityMaps(frame, self.system, self.depth)
        with_lidar = self.system.sensors[i] == LIDAR
        return maps[i, k], 0.0 if with_lidar else maps.brightness((i, k))

    def _with(self, frame: SensorFrame, sensor: Sensor) -> SensorFrame:
        if sensor not in self._tampered:
            raise ConfigurationError(f"no attack on the sensor {sensor!r} is given")
        if isinstance(sensor, int):
            return frame.with_image(sensor, self._tampered[sensor].image(sensor))
        return frame.with_points(self._tampered[sensor].points)
