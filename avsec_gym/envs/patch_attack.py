"""`avsec/PatchAttack-v0`: an attacker that chooses where a patch stands."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from avsec_gym.argument_checks import shown
from avsec_gym.attacks.attack import LEFT
from avsec_gym.attacks.patch_names import check_patch_name
from avsec_gym.envs.observations import FEATURES
from avsec_gym.envs.one_thread import one_thread
from avsec_gym.envs.parts import takes_parts
from avsec_gym.envs.patch_coding import SIZE, PatchCoding
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.envs.sensor_attack import PLAYED, RENAMED, SensorAttackEnv, Tampering
from avsec_gym.envs.sensor_attack_game import Situation
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.registry import Kind

if TYPE_CHECKING:  # torch is loaded with the detector, not before.
    from avsec_gym.attacks.patch_files import Patch


@takes_parts(Kind.ATTACK, refused=PLAYED, renamed=RENAMED)
class PatchAttackEnv(SensorAttackEnv):
    """Make the car's safe plan unsafe by standing a printed patch where it does most harm.

    ## Description
    A car finds the objects around it with a stereo detector and plans a lane change, or to keep its
    lane, among them.  The attacker has one round patch and chooses where it stands, how it is
    turned and how large it is seen; both cameras see it as a poster that faces the car.  An episode
    is one scene with one driving intention that the car drives safely without an attack.  Every
    step is one query: the car looks at the pair with the patch and plans anew, and its trajectory
    is checked for collisions with what is really there (the poster itself is no obstacle).

    With a `validator` in the car, it responds to an alarm as `response` states (it stops, drops
    the compromised sensors or repairs their data; None: it drives on), and an attack counts only
    where the car is unsafe in spite of that: by a collision, or without a plan where it did
    not stop at an alarm; where it drives on, only without an alarm.

    ## Observation
    `Box(-1, 1, (124,), float32)`: see `avsec_gym.envs.sensor_attack_features.features`; then the
    place that the patch got at the last query, as in the action, zeros at first.  With
    `observation="images"` the left image without the patch, made small,
    `Box(0, 255, (48, 160, 3), uint8)`; with `"both"` a `Dict` of `features` and `images`.

    ## Action
    `Box(-1, 1, (5,), float32)`: of the patch's centre the column, from left to right, and the row,
    from top to bottom of the left image; its disparity, from that of 20 m to that of 8 m; its
    rotation, up to 15 degrees either way; its radius, from half to whole; each scaled linearly
    (`avsec_gym.envs.patch_coding.PatchCoding.decode` and `encode`).  Where no such patch can stand
    it is moved to the nearest values that can be: both images show all of it, it is not below the
    ground, and it is in front of the real objects that it covers.

    ## Reward
    1 when the safe plan becomes unsafe (collision, or no plan), less 0.02 for the query and 0.02
    times the patch's area, as a share of the largest.

    ## Episode end
    Terminated when the plan became unsafe, or with the last query (10, or `queries`).  Only a
    smaller `max_episode_steps` truncates before.

    ## Info
    `planned`, `success`, `collision`, `safe`, `cost`, `path_length`, `smallest_distance`,
    `cost_sm1`, `outcome`, `scenario`, `intention`: see `avsec_gym.envs.info.episode_info`;
    `is_success`, `queries` (spent), `objects` (real obstacles), `found` (those that a box the car
    believes in lies on), `ghosts` (believed boxes where no obstacle is), `alarm` (of the
    validator); and of the patch `u`, `v`, `disparity`, `radius` (pixels) and `rotation` (radians),
    nan at reset, and `area` (pixels of the left image that it changed).

    ## Arguments
    * The car's parts, all but `attack`, see `avsec_gym.envs.parts.Parts`: `scenarios="mixed"`, a
      default suite of the procedural world, made in the cache on first use, or a folder in KITTI's
      object layout, or a dictionary such as `{"source": "mixed", "split": "train", "count": 10}`;
      `detector="dsgn"`, `classifier=None`, `selector=None`, `planner="astar"`, `motion="static"`,
      `score_threshold=0.3`, `road="thesis"`; `validator=None`, with `clean=None` and
      `response="stop"`.
    * `patch=None`: the package's patch against this detector, of noise where it has none (that
      against DSGN fools it no more than a grey disc: train one by `avsec attack patch`);
      `"noise"`, uniform; `"grey"`; a patch of the package, `"dsgn"`, `"stereo_rcnn"` or `"joint"`;
      a file that `avsec attack patch` made; or a live patch.
    * `observation="features"`: or `"images"`, `"both"`, see above.
    * `queries=None`: the budget that the observation counts; None: 10.  A larger one needs a
      larger `max_episode_steps`, too: for 20 queries pass both as 20, or -1 for no limit.
    * `price=0.02`: from 0 to 1.
    * `render_mode`: None, `"rgb_array"` or `"human"` (needs the extra `view`).

    `reset(options={"scenario": id, "intention": "left"})` picks a scene, safe or not; where the
    plan is unsafe without an attack, no attack succeeds.

    ## Versions
    * v0: first.
    """

    title = "avsec/PatchAttack-v0"

    def __init__(
        self,
        *,
        patch: Patch | str | Path | None = None,
        observation: str = FEATURES,
        queries: int | None = None,
        price: float = 0.02,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        super().__init__(
            SIZE,
            parts,
            QueryBudget(queries, price),
            observation=observation,
            render_mode=render_mode,
        )
        _check_patch(patch)
        self._given_patch = patch

    @cached_property
    def patch(self) -> Patch:
        """The patch that the attacker prints.

        Raises:
            DataError: The file is missing, damaged, or no patch.
        """
        from avsec_gym.attacks.patch import PatchAttack
        from avsec_gym.attacks.patch_files import shipped_patch
        from avsec_gym.perception.detectors.detector import network_name

        patch = self._given_patch
        if patch is None:
            own = shipped_patch(network_name(self.game.pipeline.detector))
            patch = own if own.is_file() else "noise"
        return cast("Patch", PatchAttack(patch).patch)

    def tamper(self, situation: Situation, action: Floats) -> Tampering:
        """Both images with the patch where the action wants it, or as near as can be."""
        from avsec_gym.attacks.patch_pasting import paste_on_frame

        frame = situation.unattacked.frame
        clean = frame.image(LEFT)
        coding = PatchCoding(frame.calibration, clean.shape[:2], self.patch.radius)
        place = coding.possible(coding.decode(action), situation.scene.boxes)
        with one_thread():
            attacked = paste_on_frame(frame, self.patch.pixels, place)
        changed = np.abs(np.rint(attacked.image(LEFT)) - clean).max(axis=2) > 0
        facts = {
            "u": place.u,
            "v": place.v,
            "disparity": place.disparity,
            "radius": place.radius,
            "rotation": place.rotation,
            "area": int(changed.sum()),
        }
        used = (place.radius / self.patch.radius) ** 2
        return Tampering(attacked, used, facts, coding.encode(place))

    @property
    def untouched(self) -> dict[str, float]:
        """No patch."""
        return dict.fromkeys(("u", "v", "disparity", "radius", "rotation"), np.nan) | {"area": 0}


def _check_patch(patch: Patch | str | Path | None) -> None:
    """Refuse a name of nothing; a file is read when the patch is pasted.

    Raises:
        ConfigurationError: A mistyped name, or no patch.
        DataError: There is no such file.
    """
    if isinstance(patch, str | Path):
        check_patch_name(patch)
    elif patch is not None and not hasattr(patch, "pixels"):
        raise ConfigurationError(f"a patch is a name, a file or a Patch, got {shown(patch)}")
