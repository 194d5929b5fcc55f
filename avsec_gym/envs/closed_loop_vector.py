"""The vectorised entry point of `avsec/ClosedLoop-v0`: drives as arrays, without highway-env."""

from __future__ import annotations

from typing import Any

from avsec_gym.argument_checks import number, one_of
from avsec_gym.closed_loop.loop_scenes import LoopScenes
from avsec_gym.closed_loop.reacting import RECORDED, reacting_of
from avsec_gym.closed_loop.traffic_scene import DURATION
from avsec_gym.envs.closed_loop import REFUSED
from avsec_gym.envs.closed_loop_parts import checked_scenarios, light_perceptions, perception_of
from avsec_gym.envs.light_closed_loop import LightClosedLoopEnv, SharedScenes
from avsec_gym.envs.many_drives import ALONE, ManyDrives, checked_count
from avsec_gym.envs.observations import FEATURES, FRAME
from avsec_gym.envs.parts import parts_of, takes_parts
from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind
from avsec_gym.scenario.scene import Motion

PLACES = 512
"""Scenes that stay laid out."""


@takes_parts(Kind.PLANNER, refused=REFUSED, scenarios="drives", motion="truth")
class ClosedLoopVectorEnv(ManyDrives[LightClosedLoopEnv]):
    """`ClosedLoopEnv` many times over; see there for the arguments.

    ``gym.make_vec("avsec/ClosedLoop-v0", num_envs=64)`` makes it.  Recorded traffic, continuous
    actions and the observation of one flat vector are what it has; perception by ``"truth"``,
    ``"blind"`` or an error model.  What else a single environment has is refused.

    Raises:
        ConfigurationError: An argument is wrong, or one that only a single environment has.
    """

    title = "avsec/ClosedLoop-v0"

    def __init__(
        self,
        num_envs: int = 1,
        perception: Any = "truth",
        traffic: Any = RECORDED,
        observation: str = FEATURES,
        duration: float = DURATION,
        handover: float | None = None,
        config: dict[str, Any] | None = None,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        observed = one_of("observation", observation, (FEATURES, FRAME))
        if observed != FEATURES or "frame_size" in parts:
            raise ConfigurationError(f"many drives at once have no frames to observe: {ALONE}")
        taken = parts_of(self, parts)
        check_is_light(traffic, config, render_mode)
        if handover is not None:
            raise ConfigurationError(f"many drives at once are not handed over: {ALONE}")
        count = checked_count(num_envs)
        made, self.planner = perception_of(perception, taken)
        perceptions = light_perceptions(made, Motion.named(taken.motion), count)
        duration = number("duration", duration, 0.5, 30.0)
        shared = SharedScenes(checked_scenarios(taken.scenarios), duration, PLACES)
        super().__init__([LightClosedLoopEnv(shared, each, self.planner) for each in perceptions])

    @property
    def scenes(self) -> LoopScenes:
        """The scenes to drive in, read when they are first needed."""
        return self.alone[0].scenes


def check_is_light(traffic: Any, config: dict[str, Any] | None, render_mode: str | None) -> None:
    """Refuse what only drives on highway-env have.

    Raises:
        ConfigurationError: Something is given that they alone have.
    """
    if not reacting_of(traffic).is_recorded:
        raise ConfigurationError(f"many drives at once have recorded traffic: {ALONE}")
    if config is not None:
        raise ConfigurationError(f"many drives at once have no config: {ALONE}")
    if render_mode is not None:
        raise ConfigurationError(f"many drives at once are not rendered: {ALONE}")
