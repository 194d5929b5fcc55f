"""`avsec/PerturbationAttack-v0`: a black-box attacker on the pixels of a stereo pair."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import flag, shown, whole_number
from avsec_gym.attacks.attack import LEFT, RIGHT, Budget
from avsec_gym.built_in_parts import BUILT_IN
from avsec_gym.envs.gradient_basis import GradientBasis
from avsec_gym.envs.observations import FEATURES
from avsec_gym.envs.parts import Parts, takes_parts
from avsec_gym.envs.query_budget import QueryBudget
from avsec_gym.envs.sensor_attack import PLAYED, RENAMED, SensorAttackEnv, Tampering
from avsec_gym.envs.sensor_attack_game import SensorAttackGame, Situation
from avsec_gym.envs.wave_basis import WaveBasis
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Image
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.registry import Kind


@takes_parts(Kind.ATTACK, refused=PLAYED, renamed=RENAMED)
class PerturbationAttackEnv(SensorAttackEnv):
    """Make the car's safe plan unsafe by changing every pixel a little, the detector a black box.

    ## Description
    A car finds the objects around it with a stereo detector and plans a lane change, or to keep its
    lane, among them.  The attacker adds a pattern to both images: a sum of a few plane waves, of
    which only the sign counts, so that nearly every pixel changes by as much as is allowed.  It
    cannot look into the detector; it sees the scene and the result of its last query.  An episode
    is one scene with one driving intention that the car drives safely without an attack.  Every
    step is one query: the car looks at the attacked pair and plans anew, and its trajectory is
    checked for collisions with what is really there.

    With a `surrogate`, a detector that the attacker owns, the pattern is a sum of the gradients of
    the terms of its training loss instead of waves: what fools one detector may fool another.  The
    car's own detector stays a black box.

    With a `validator` in the car, it responds to an alarm as `response` states (it stops, drops
    the compromised sensors or repairs their data; None: it drives on), and an attack counts only
    where the car is unsafe in spite of that: by a collision, or without a plan where it did
    not stop at an alarm; where it drives on, only without an alarm.

    ## Observation
    `Box(-1, 1, (119 + n,), float32)` for actions of n numbers: see
    `avsec_gym.envs.sensor_attack_features.features`; then the last action, zeros at first.  With
    `observation="images"` the left image without the attack, made small,
    `Box(0, 255, (48, 160, 3), uint8)`; with `"both"` a `Dict` of `features` and `images`.

    ## Action
    `Box(-1, 1, (2 waves,), float32)`: coefficients of the cosines, then of the sines.  Both images
    are changed by ``strength * sign(sum of the waves)``, all three colours alike: the coefficients'
    proportions make the pattern, and the largest of them, times `epsilon`, the strength.  With
    `shared=False` the second half of twice as many coefficients makes the right image's pattern.
    Attacked images have whole grey levels in 0..255.  `avsec_gym.envs.wave_basis.WaveBasis` lists
    the waves.  With a `surrogate` there is a coefficient for each term of its loss, colours change
    by themselves, and `shared=True` adds up the gradients of both images
    (`avsec_gym.envs.gradient_basis.GradientBasis`).

    ## Reward
    1 when the safe plan becomes unsafe (collision, or no plan), less 0.02 for the query and 0.02
    times strength / `epsilon`.

    ## Episode end
    Terminated when the plan became unsafe, or with the last query (10, or `queries`).  Only a
    smaller `max_episode_steps` truncates before.

    ## Info
    `planned`, `success`, `collision`, `safe`, `cost`, `path_length`, `smallest_distance`,
    `cost_sm1`, `outcome`, `scenario`, `intention`: see `avsec_gym.envs.info.episode_info`;
    `is_success`, `queries` (spent), `objects` (real obstacles), `found` (those that a box the car
    believes in lies on), `ghosts` (believed boxes where no obstacle is), `alarm` (of the
    validator), `change` (the largest of any pixel, grey levels).

    ## Arguments
    * The car's parts, all but `attack`, see `avsec_gym.envs.parts.Parts`: `scenarios="mixed"`, a
      default suite of the procedural world, made in the cache on first use, or a folder in KITTI's
      object layout, or a dictionary such as `{"source": "mixed", "split": "train", "count": 10}`;
      `detector="dsgn"`, `classifier=None`, `selector=None`, `planner="astar"`, `motion="static"`,
      `score_threshold=0.3`, `road="thesis"`; `validator=None`, with `clean=None` and
      `response="stop"`.
    * `epsilon=8`: grey levels, a whole number from 1 to 255, as a camera's are.
    * `waves=8`: at most 256; `wavelengths=(12, 60)`: shortest and longest, pixels of the camera,
      from 2 to 10,000.
    * `surrogate=None`: a detector of another network than the car's, or of other weights, as
      `detector` is named, whose gradients take the waves' place; `terms=None`: names of terms of
      its loss, None: of `"dsgn"` `classification`, `box` and `centerness`, of `"stereo_rcnn"` its
      six.
    * `shared=True`: both images get one pattern, as in the text of the thesis.
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

    title = "avsec/PerturbationAttack-v0"

    def __init__(
        self,
        *,
        epsilon: int = 8,
        waves: int = 8,
        wavelengths: tuple[float, float] = (12.0, 60.0),
        surrogate: Any = None,
        terms: Sequence[str] | None = None,
        shared: bool = True,
        observation: str = FEATURES,
        queries: int | None = None,
        price: float = 0.02,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        self.basis: WaveBasis | GradientBasis = WaveBasis(waves, wavelengths)
        if surrogate is not None:
            _check_other(surrogate, parts.get("detector", Parts.detector))
            self.basis = GradientBasis(surrogate, terms)
        elif terms is not None:
            raise ConfigurationError(
                "terms are those of a surrogate's loss: name it, such as surrogate="
                '"stereo_rcnn", or leave them out'
            )
        self.budget = Budget(float(whole_number("epsilon", epsilon, 1, 255)))
        self.shared = flag("shared", shared)
        super().__init__(
            self.basis.size * (1 if self.shared else 2),
            parts,
            QueryBudget(queries, price),
            observation=observation,
            render_mode=render_mode,
        )

    @cached_property
    def game(self) -> SensorAttackGame:
        """Scenes and victim, whose network is another than the surrogate's.

        Raises:
            ConfigurationError: It is the same, or there is no such set or part.
            DataError: A file, such as the detector's weights, is missing or broken.
        """
        game = SensorAttackGame(self.parts)
        if isinstance(self.basis, GradientBasis):
            _check_weights(self.basis.surrogate, game.pipeline.detector)
        return game

    def tamper(self, situation: Situation, action: Floats) -> Tampering:
        """Both images with the pattern of these coefficients."""
        frame = situation.unattacked.frame
        used = float(np.abs(action).max())
        change = 0.0
        for view, camera in enumerate((LEFT, RIGHT)):
            image = frame.image(camera)
            coefficients = action.reshape(-1, self.basis.size)[0 if self.shared else view]
            pattern = self._pattern(situation, coefficients, view)
            attacked = np.clip(np.rint(image + used * self.budget.change * pattern), 0, 255)
            change = max(change, float(np.abs(attacked - image).max()))
            frame = frame.with_image(camera, cast(Image, attacked.astype(np.uint8)))
        return Tampering(frame, used, {"change": change}, action)

    @property
    def untouched(self) -> dict[str, float]:
        """No change."""
        return {"change": 0.0}

    def _pattern(self, situation: Situation, coefficients: Floats, view: int) -> NDArray[np.int8]:
        """The signs of the change of the left (0) or right (1) image, shape (H, W, 1 or 3)."""
        frame = situation.unattacked.frame
        if isinstance(self.basis, WaveBasis):
            return self.basis.pattern(coefficients, frame.image(LEFT).shape[:2])[..., None]
        images = self.basis.images(frame, situation.scene.boxes)
        return self.basis.pattern(coefficients, images.sum(axis=0) if self.shared else images[view])


def _check_other(surrogate: Any, detector: Any) -> None:
    """Refuse the car's own detector as a surrogate, whatever stands before either.

    Args:
        surrogate: The surrogate, by name, as a dictionary, or a live one.
        detector: The car's detector likewise.

    Raises:
        ConfigurationError: They are the same.
    """
    one, other = _within(surrogate), _within(detector)
    if one is other or (isinstance(one, Mapping) and one == other):
        raise _own(surrogate)


def _check_weights(surrogate: Detector, detector: Detector) -> None:
    """Refuse a surrogate of the car's own weights.

    Raises:
        ConfigurationError: Their networks have the same.
    """
    from avsec_gym.perception.weights.weights_hash import weights_hash

    own = weights_hash(surrogate)
    if own is not None and own == weights_hash(detector):
        raise _own(surrogate.name)


def _within(detector: Any) -> Any:
    """The detector within defended and attacked ones; a named one with its name's defaults."""
    while isinstance(detector, Mapping) and detector.get("name") in ("attacked", "defended"):
        detector = detector.get("detector")
    given = {"name": detector} if isinstance(detector, str) else detector
    if not isinstance(given, Mapping):
        return given
    _, defaults = BUILT_IN.get((Kind.DETECTOR, str(given.get("name"))), ("", {}))
    return {**defaults, **given}


def _own(surrogate: Any) -> ConfigurationError:
    return ConfigurationError(
        f"the surrogate {shown(surrogate)} is the car's own detector, which the attacker cannot"
        ' look into: name another one, such as "stereo_rcnn" or "dsgn", or other weights'
    )
