"""`avsec/FaculaAttack-v0`: a laser that shines into one camera of a stereo pair."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from avsec_gym.attacks.attack import LEFT
from avsec_gym.attacks.facula import THESIS_RADII
from avsec_gym.envs.facula_coding import FaculaCoding
from avsec_gym.envs.observations import FEATURES
from avsec_gym.envs.optical_attack import OpticalAttackEnv
from avsec_gym.envs.parts import takes_parts
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.envs.sensor_attack import PLAYED, RENAMED, Tampering
from avsec_gym.envs.sensor_attack_game import Situation
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.registry import Kind
from avsec_gym.rig import KITTI_SIZE


@takes_parts(Kind.ATTACK, refused=PLAYED, renamed=RENAMED)
class FaculaAttackEnv(OpticalAttackEnv):
    """Make the car's safe plan unsafe by shining a laser into a camera.

    ## Description
    A car finds the objects around it with a stereo detector and plans a lane change, or to keep its
    lane, among them.  The attacker shines a laser into one of the two cameras: a round spot of
    Gaussian profile, as in the thesis (section 3.2.3), which hides what is behind it.  It chooses
    the camera, where the spot is, and how large; it cannot look into the detector.  An episode is
    one scene with one driving intention that, without an attack, the car drives safely and without
    an alarm.  Every step is one query: the car looks at the attacked pair and plans anew, and its
    trajectory is checked for collisions with what is really there.

    In most situations no object is in the way, and a car that sees nothing at all drives as
    safely: `scenarios={"source": "mixed", "contested": True}` draws those in which one is.

    With a `validator` in the car, it responds to an alarm as `response` states (it stops, drops
    the compromised sensors or repairs their data; None: it drives on), and an attack counts only
    where the car is unsafe in spite of that: by a collision, or without a plan where it did
    not stop at an alarm; where it drives on, only without an alarm.

    ## Observation
    `Box(-1, 1, (128,), float32)`: see `avsec_gym.envs.sensor_attack_features.features`; whether the
    last query raised an alarm, and the shares that the validator compared (`error`, `hole_share`,
    `densest`, `brightness`; before the first query those without an attack); then the last action,
    zeros at first.  With `observation="images"` the left image without the attack, made small,
    `Box(0, 255, (48, 160, 3), uint8)`; with `"both"` a `Dict` of `features` and `images`.

    ## Action
    `Box(-1, 1, (4,), float32)`: the right camera (3) if above 0, else the left (2); column and row
    of the spot's centre, from the left upper to the right lower corner of that camera's image; its
    radius, from the first to the second of `radii`; each scaled linearly
    (`avsec_gym.envs.facula_coding.FaculaCoding.decode` and `encode`).  With two numbers for
    `strength` it is `Box(-1, 1, (5,), float32)`: how strong the light is, from the first to the
    second, and the observation is one longer.

    ## Reward
    1 when the safe plan becomes unsafe (collision, or no plan) in spite of the validator, less
    0.02 for the query and 0.02 times the spot's area, as a share of the largest.

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
    `avsec_gym.validation.evidence.disparity_error`; 0 without a validator); and of the spot
    `camera` (-1 at reset), `u`, `v`, `radius` (pixels, nan at reset), `strength` (grey levels, 0 at
    reset) and `area` (pixels within the radius that it changed).

    ## Arguments
    * The car's parts, all but `attack`, see `avsec_gym.envs.parts.Parts`: `scenarios="mixed"`, a
      default suite of the procedural world, made in the cache on first use, or a folder in KITTI's
      object layout, or a dictionary such as `{"source": "mixed", "split": "train", "count": 10}`;
      `detector="dsgn"`, `classifier=None`, `selector=None`, `planner="astar"`, `motion="static"`,
      `score_threshold=0.3`, `road="thesis"`; `validator=None`, with `clean=None` and
      `response="stop"`.
    * `radii=(37.5, 375)`: pixels of an image 1242 wide, in proportion in others; within 0.1 and
      10,000.
    * `strength=255`: of the light at its peak, grey levels, from 0.1 to 2550; two numbers: the
      attacker chooses.
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

    title = "avsec/FaculaAttack-v0"

    def __init__(
        self,
        *,
        radii: tuple[float, float] = (37.5, THESIS_RADII[1]),
        strength: float | tuple[float, float] = 255.0,
        observation: str = FEATURES,
        queries: int | None = None,
        price: float = 0.02,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        width, height = KITTI_SIZE
        self._codes = FaculaCoding((height, width), radii, strength)
        super().__init__(
            self._codes.action_size,
            parts,
            QueryBudget(queries, price),
            observation=observation,
            render_mode=render_mode,
        )

    def coding(self, frame: SensorFrame) -> FaculaCoding:
        """The coding between actions and faculae, for images of a frame's size."""
        return replace(self._codes, size=frame.image(LEFT).shape[:2])

    def tamper(self, situation: Situation, action: Floats) -> Tampering:
        """One image with the spot in it."""
        frame = situation.unattacked.frame
        facula = self.coding(frame).decode(action)
        tampered = facula.attack(frame)
        [pixels] = tampered.pixels.values()
        facts = {"camera": facula.camera, **tampered.settings}
        facts |= {"strength": facula.strength, "area": int(pixels.sum())}
        used = (tampered.settings["radius"] / self._codes.radii[1]) ** 2
        return Tampering(tampered.frame, used, facts, action)

    @property
    def untouched(self) -> dict[str, float]:
        """No spot."""
        nowhere = dict.fromkeys(("radius", "u", "v"), np.nan)
        return {"camera": -1, **nowhere, "strength": 0.0, "area": 0}

    def view(self) -> tuple[SensorFrame, int]:
        """The camera that was shone into."""
        frame = self._look.frame
        return frame, LEFT if self._last is None else self.coding(frame).decode(self._done).camera
