"""`avsec/LidarSpoofing-v0`: an attacker that makes a LiDAR see what is not there."""

from __future__ import annotations

from typing import Any

import numpy as np

from avsec_gym.attacks.attack import LEFT
from avsec_gym.envs.attacked_sensors import SCAN
from avsec_gym.envs.observations import FEATURES
from avsec_gym.envs.optical_attack import OpticalAttackEnv
from avsec_gym.envs.parts import takes_parts
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.envs.sensor_attack import PLAYED, RENAMED, Tampering
from avsec_gym.envs.sensor_attack_game import Situation
from avsec_gym.envs.spoofing_coding import SIZE, Ends, SpoofingCoding
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.registry import Kind


@takes_parts(Kind.ATTACK, refused=PLAYED, renamed=RENAMED, detector="scan_obstacles")
class LidarSpoofingEnv(OpticalAttackEnv):
    """Make the car's safe plan unsafe by bogus returns of a LiDAR.

    **Solved by a constant.**  Against the default car the largest patch, nearest and straight ahead
    (`[-1, 0, 1, 1]`), wins at the first query: whatever stands up from the ground is an obstacle to
    it, and it finds no plan.  What there is to learn needs a car with a `validator`, or a
    `detector` that has learned what cars look like, such as `"pixor"`.

    ## Description
    A car finds the objects around it in a LiDAR scan and plans a lane change, or to keep its lane,
    among them.  The attacker fires into the LiDAR in step with it: the scan gets the points of an
    upright plane patch that stands on the road and faces the car, as in the thesis (section 3.2.3).
    It chooses where the patch is and how large; it cannot look into the detector.  An episode is
    one scene with one driving intention that, without an attack, the car drives safely and without
    an alarm.  Every step is one query: the car looks at the attacked scan and plans anew, and its
    trajectory is checked for collisions with what is really there (the patch is nothing).

    The car's detector is by itself no network, but the obstacles that the scan shows: whatever
    stands up from the ground (`avsec_gym.perception.detectors.scan_obstacles.ScanObstacles`).  It
    needs no weights, and takes walls and poles for what they are, obstacles; so it has boxes where
    no labelled object is, and they count as `ghosts`.  `detector="pixor"` is one that has learned
    what cars look like.

    With a `validator` in the car, it responds to an alarm as `response` states (it stops, drops
    the compromised sensors or repairs their data; None: it drives on), and an attack counts only
    where the car is unsafe in spite of that: by a collision, or without a plan where it did
    not stop at an alarm; where it drives on, only without an alarm.

    ## Observation
    `Box(-1, 1, (128,), float32)`: see `avsec_gym.envs.sensor_attack_features.features`; whether the
    last query raised an alarm, and the shares that the validator compared (`error`, `hole_share`,
    `densest`, `brightness`; before the first query those without an attack); then the last action,
    zeros at first.  With `observation="images"` the left image, made small,
    `Box(0, 255, (48, 160, 3), uint8)`; with `"both"` a `Dict` of `features` and `images`.

    ## Action
    `Box(-1, 1, (4,), float32)`: of the patch its distance from the LiDAR along the ground, its
    bearing (positive to the left), its width and its height, each from the first to the second of
    its range, scaled linearly (`avsec_gym.envs.spoofing_coding.SpoofingCoding.decode` and
    `encode`).

    ## Reward
    1 when the safe plan becomes unsafe (collision, or no plan) in spite of the validator, less
    0.02 for the query and 0.02 times the patch's area, as a share of the largest.

    ## Episode end
    Terminated when the attack counts, or with the last query (10, or `queries`).  Only a
    smaller `max_episode_steps` truncates before.

    ## Info
    `planned`, `success`, `collision`, `safe`, `cost`, `path_length`, `smallest_distance`,
    `cost_sm1`, `outcome`, `scenario`, `intention`: see `avsec_gym.envs.info.episode_info`;
    `is_success` (unsafe, in spite of the validator), `queries` (spent), `objects` (real obstacles),
    `found` (those that a box the car believes in lies on), `ghosts` (believed boxes where no
    obstacle is); `alarm`, and of the shares that the validator compared the largest among its
    triples of sensors: `error` (the disparity error E), `hole_share`, `densest`, `brightness` (see
    `avsec_gym.validation.evidence.disparity_error`; 0 without a validator); and of the patch
    `distance`, `width`, `height` (metres) and `bearing` (radians), nan at reset, and `points`
    (bogus ones).

    ## Arguments
    * The car's parts, all but `attack`, see `avsec_gym.envs.parts.Parts`: `scenarios="mixed"`, a
      default suite of the procedural world, made in the cache on first use, or a folder in KITTI's
      object layout, or a dictionary such as `{"source": "mixed", "split": "train", "count": 10}`;
      `detector="scan_obstacles"`, since the car has to see what is attacked (`"pixor"` is a network
      of the package); `classifier=None`, `selector=None`, `planner="astar"`, `motion="static"`,
      `score_threshold=0.3`, `road="thesis"`; `validator=None`, with `clean=None` and
      `response="stop"`.
    * `distances=(5, 40)`, `widths=(0.5, 2.5)`, `heights=(0.5, 1.5)`: metres, up to 120, 50 and 10.
    * `bearings=(-0.7, 0.7)`: radians, about what KITTI's cameras see; within a turn.
    * `rays_lost=False`: points are added, as in the thesis; True: beams that meet the patch return
      nothing from behind it.
    * `observation="features"`: or `"images"`, `"both"`, see above.
    * `queries=None`: the budget that the observation counts; None: 10.  A larger one needs a
      larger `max_episode_steps`, too: for 20 queries pass both as 20, or -1 for no limit.
    * `price=0.02`: from 0 to 1.
    * `render_mode`: None, `"rgb_array"` or `"human"` (needs the extra `view`).

    `reset(options={"scenario": id, "intention": "left"})` picks a scene, safe or not; where the
    plan is unsafe or raises an alarm without an attack, no attack succeeds.

    ## Versions
    * v0: first.
    """

    title = "avsec/LidarSpoofing-v0"
    attacked = SCAN

    def __init__(
        self,
        *,
        distances: Ends = (5.0, 40.0),
        bearings: Ends = (-0.7, 0.7),
        widths: Ends = (0.5, 2.5),
        heights: Ends = (0.5, 1.5),
        rays_lost: bool = False,
        observation: str = FEATURES,
        queries: int | None = None,
        price: float = 0.02,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        self.coding = SpoofingCoding(distances, bearings, widths, heights, rays_lost)
        super().__init__(
            SIZE,
            parts,
            QueryBudget(queries, price),
            observation=observation,
            render_mode=render_mode,
        )

    def tamper(self, situation: Situation, action: Floats) -> Tampering:
        """The scan with the bogus points in it."""
        attack = self.coding.decode(action)
        tampered = attack.attack(situation.unattacked.frame)
        size = {"width": attack.width, "height": attack.height}
        bogus = 0 if tampered.points is None else int(tampered.points.sum())
        facts = {**tampered.settings, **size, "points": bogus}
        used = attack.width * attack.height / self.coding.largest
        return Tampering(tampered.frame, used, facts, action)

    @property
    def untouched(self) -> dict[str, float]:
        """No patch."""
        return dict.fromkeys(("distance", "bearing", "width", "height"), np.nan) | {"points": 0}

    def view(self) -> tuple[SensorFrame, int]:
        """The left image with the scan over it."""
        from avsec_gym.drawing.frame_picture import points_in_image

        frame = self._look.frame
        return frame.with_image(LEFT, points_in_image(frame.image(LEFT), frame, LEFT)), LEFT
