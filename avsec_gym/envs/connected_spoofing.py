"""`avsec/ConnectedSpoofing-v0`: an attacker who pastes a scan into one of several vehicles'."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.object_scan import ObjectScan
from avsec_gym.envs.actions import LinearScale, checked_action
from avsec_gym.envs.connected_instants import (
    REFUSED,
    SUITE,
    NamedInstants,
    PlayedInstants,
    vehicles_of,
    without_an_episode,
)
from avsec_gym.envs.parts import parts_of, takes_parts
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.envs.rendering import DrawnEnv
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.geometry import Floats
from avsec_gym.registry import Kind
from avsec_gym.scenario.intention import Intention, intentions_named
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject, pasteable_scans
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.proposals.remembered import RememberedProposals
from avsec_gym.validation.connected.rays.decision import NO_ATTACK
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

Observation = NDArray[np.float32]
PLACE = LinearScale(np.array([5.0, -np.pi]), np.array([40.0, np.pi]))
"""Distance of a ghost from its victim's LiDAR, metres, and its bearing, radians to the left."""
SECTORS = 12
_FAR, _ACTION, _REPORTED = 60.0, 4, 5
_STANDS = (-1.2, 0.6)
"""Heights in the velodyne frame between which a return comes from what stands on the road."""


@takes_parts(
    Kind.ATTACK,
    refused={name: reason for name, reason in REFUSED.items() if name != "attack"}
    | {
        "attack": "the agent plays it",
        "validator": "the base station that the package ships a fit for is what is spoofed",
    },
    scenarios=SUITE,
)
class ConnectedSpoofingEnv(DrawnEnv[Observation]):
    """Paste an object's scan into one vehicle's such that it is believed, and no one objects.

    ## Description
    Several vehicles with LiDARs and a base station compare what they see (thesis, chapter 4).  The
    agent chooses the victim, one of the objects that the vehicles scanned at this instant, and
    where its scan is pasted into the victim's, turned such that the sides that were scanned face
    the LiDAR.  The base station reports what it decided, and the agent may try again.

    ## Observation
    `Box(-1, 1, (4 V (V - 1) + 12 V + 10,), float32)` for V vehicles: of each vehicle where every
    other one is, x and y in its velodyne frame over 60 m and the cosine and sine of its heading
    there; of each vehicle the distance of the nearest thing that stands in each of twelve sectors,
    from behind to the left by way of the right, over 60 m (1: nothing); of the last query whether
    the ghost was blocked (no free place), believed (a region of it was compared), decided by two
    vehicles' rays, raised an alarm, and named the victim; the last action; the share of the queries
    that is left.  Zeros stand for the last query at first.  For three vehicles 70 numbers.

    ## Action
    `Box(-1, 1, (4,), float32)`: the victim (equal parts of the range), the scan that is pasted (of
    at most eight, those with most points first; equal parts), the distance from the victim's
    LiDAR, 5 to 40 m, and the bearing, -pi to pi to the left, both scaled linearly
    (`avsec_gym.envs.connected_spoofing.PLACE.decode` and `encode`).

    ## Reward
    1 when the ghost is believed and no region of it alarms, less 0.02 for the query.

    ## Episode end
    Terminated when the attack succeeds, or with the last query (10, or `queries`).  Only a
    smaller `max_episode_steps` truncates before.

    ## Info
    `is_success` (believed without an alarm), `queries` (spent), `victim` (-1 at reset), `points`
    (bogus ones), `blocked`, `believed`, `decidable`, `alarm`, `named` (whether the victim was),
    `distance` (metres) and `bearing` (radians), 0 at reset.  As in every environment, `planned`,
    `success`, `collision`, `safe`, `cost`, `path_length`, `smallest_distance`, `cost_sm1`,
    `outcome`, `scenario` (the instant's id), `intention`: no car drives, so that the numbers are 0
    and the outcome is `unplanned`.

    ## Arguments
    * `scenarios="connected"`: the default suite, made in the cache on first use; a folder of
      `avsec world make --suite connected`; a dictionary such as `{"source": "data/connected",
      "first": 0, "count": 20}`, to train and to judge on different ones.
    * `queries=None`: the budget that the observation counts; None: 10.  A larger one needs a
      larger `max_episode_steps`, too: for 20 queries pass both as 20, or -1 for no limit.
    * `price=0.02`: of a query, from 0 to 1.
    * `render_mode`: None, `"rgb_array"` or `"human"` (needs the extra `view`).

    `reset(options={"scenario": id})` picks an instant.

    ## Versions
    * v0: first.
    """

    title = "avsec/ConnectedSpoofing-v0"

    def __init__(
        self,
        *,
        queries: int | None = None,
        price: float = 0.02,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        super().__init__(render_mode)
        self.parts = parts_of(self, parts)
        self._scenarios = NamedInstants(self.parts.scenarios)
        self.budget = QueryBudget(queries, price)
        self.vehicles = vehicles_of(self._scenarios)
        others = self.vehicles - 1
        size = 4 * self.vehicles * others + SECTORS * self.vehicles + _REPORTED + _ACTION + 1
        self.observation_space = gym.spaces.Box(-1.0, 1.0, (size,), np.float32)
        self.action_space = gym.spaces.Box(-1.0, 1.0, (_ACTION,), np.float32)
        self._id, self._intention = "", Intention.STRAIGHT
        self._instant: RecordedInstant | None = None
        self._scans: list[ObjectScan] = []
        self._scene: Floats = np.zeros(0)
        self._spent = 0
        self._action = np.zeros(_ACTION)
        self._attacked: AttackedInstant | None = None
        self._result: ConnectedResult | None = None
        self._victim, self._distance, self._bearing = -1, 0.0, 0.0

    @cached_property
    def instants(self) -> PlayedInstants:
        """The instants that are played, without an attack."""
        return PlayedInstants(self._scenarios)

    @cached_property
    def station(self) -> ConnectedValidator:
        """The vehicles and the base station that are spoofed."""
        constants = read_connected_fit(SHIPPED_FIT).constants()
        return ConnectedValidator(constants, "rays", RememberedProposals())

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Draw an instant; ``options`` may pick it, and an ``intention``."""
        super().reset(seed=seed)
        options = reset_options(options)
        random, ids = self.np_random, self.instants.ids
        intentions = intentions_named(options.get("intention"))
        self._intention = intentions[int(random.integers(len(intentions)))]
        drawn, picked = ids[int(random.integers(len(ids)))], options.get("scenario")
        self._id = drawn if picked is None else self.instants.named(picked)
        self._instant = self.instants.instant(self._id)
        self._scans = pasteable_scans(self._instant)
        self._scene = scene_features(self._instant.scans)
        self._spent = 0
        self._forget()
        self.shown()
        return self._observe(), self._info()

    def step(self, action: NDArray[Any]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Paste, and hear what the base station decided.

        Raises:
            ResetNeeded: There is no instant yet.
        """
        if self._instant is None:
            raise gym.error.ResetNeeded("call reset before step")
        self._forget()
        self._action = checked_action(action, _ACTION)
        self._spent += 1
        self._victim = _part(self._action[0], self.vehicles)
        self._distance, self._bearing = PLACE.decode(self._action[2:]).tolist()
        if self._scans:
            attack = PastedObject(
                self._victim,
                (self._distance, self._distance),
                self._bearing,
                self._scans[_part(self._action[1], len(self._scans))],
            )
            self._attacked = attack.attack(self._instant)
        if self._attacked is not None:
            self._result = self.station.validate(self._attacked.instant.scans, id=self._id)
        self.shown()
        info = self._info()
        success = bool(info["is_success"])
        reward = float(success) - self.budget.price
        terminated = success or self.budget.ends(self._spent)
        return self._observe(), float(reward), terminated, False, info

    def picture(self) -> NDArray[np.uint8] | None:
        """All scans from above, the last ghost among them, and what the station decided."""
        if self._instant is None:
            return None
        from avsec_gym.drawing.connected_picture import draw_connected
        from avsec_gym.drawing.scenario_picture import picture_array

        shown = self._instant if self._attacked is None else self._attacked.instant
        result = self._result or self.station.validate(shown.scans, id=self._id)
        return picture_array(draw_connected(result, shown.scans))

    def _forget(self) -> None:
        """Nothing was tried yet, or something new is."""
        self._action = np.zeros(_ACTION)
        self._attacked = self._result = None
        self._victim, self._distance, self._bearing = -1, 0.0, 0.0

    def _reported(self) -> dict[str, bool]:
        """What became of the last query."""
        if self._attacked is None or self._result is None:
            nothing = dict.fromkeys(("believed", "decidable", "alarm", "named"), False)
            return {"blocked": self._victim >= 0, **nothing}
        about = self._attacked.regions(self._result.regions)
        named = self._result.named[about]
        return {
            "blocked": False,
            "believed": bool(about.any()),
            "decidable": bool((about & self._result.decidable).any()),
            "alarm": bool((named != NO_ATTACK).any()),
            "named": bool((named == self._victim).any()),
        }

    def _observe(self) -> Observation:
        reported = np.array(list(self._reported().values()), float)
        left = self.budget.left(min(self._spent, self.budget.count))
        parts = [self._scene, reported, self._action, np.array([left])]
        return np.concatenate(parts).astype(np.float32)

    def _info(self) -> dict[str, Any]:
        reported = self._reported()
        return {
            **without_an_episode(self._id, str(self._intention), over=self._victim >= 0),
            "is_success": reported["believed"] and not reported["alarm"],
            "queries": self._spent,
            "victim": self._victim,
            "points": 0 if self._attacked is None else self._attacked.points,
            **reported,
            "distance": self._distance,
            "bearing": self._bearing,
        }


def scene_features(scans: tuple[VehicleScan, ...]) -> Floats:
    """Where the others are for each vehicle, and how far things stand in each sector around it.

    Returns:
        Shape (4 V (V - 1) + 12 V,), from -1 to 1; see `ConnectedSpoofingEnv`.
    """
    places, sectors = [], []
    for scan in scans:
        for other in scans:
            if other is not scan:
                seen = np.linalg.inv(scan.pose) @ other.pose
                where = np.clip(seen[:2, 3] / _FAR, -1.0, 1.0)
                heading = np.arctan2(seen[1, 0], seen[0, 0])
                places += [*where, np.cos(heading), np.sin(heading)]
        points = scan.points[:, :3].astype(np.float64)
        stands = points[(points[:, 2] > _STANDS[0]) & (points[:, 2] < _STANDS[1])]
        bearing = np.arctan2(stands[:, 1], stands[:, 0])
        sector = np.minimum(((bearing + np.pi) / (2 * np.pi) * SECTORS).astype(int), SECTORS - 1)
        nearest = np.full(SECTORS, _FAR)
        np.minimum.at(nearest, sector, np.hypot(stands[:, 0], stands[:, 1]))
        sectors += (nearest / _FAR).tolist()
    return np.array([*places, *sectors])


def _part(value: float, count: int) -> int:
    """Which of equal parts of [-1, 1] a value lies in."""
    return min(int((value + 1.0) / 2.0 * count), count - 1)
