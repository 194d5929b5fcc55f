"""The vectorised entry point of `avsec/ClosedLoopAttack-v0`: attacked drives as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.closed_loop.error_model.perception import ErrorModelPerception
from avsec_gym.closed_loop.light.beliefs import light_perception
from avsec_gym.closed_loop.perception import DrivePerception
from avsec_gym.closed_loop.reacting import RECORDED
from avsec_gym.closed_loop.traffic_scene import DURATION
from avsec_gym.envs.closed_loop_attack import REFUSED, ClosedLoopAttackEnv
from avsec_gym.envs.closed_loop_parts import light_perceptions, perception_of
from avsec_gym.envs.closed_loop_vector import PLACES, check_is_light
from avsec_gym.envs.judged_drives import JudgedDrives
from avsec_gym.envs.light_closed_loop import LightClosedLoopEnv, SharedScenes
from avsec_gym.envs.many_drives import ALONE, ManyDrives, checked_count
from avsec_gym.envs.parts import parts_of, takes_parts
from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind
from avsec_gym.scenario.scene import Motion


class LightClosedLoopAttackEnv(ClosedLoopAttackEnv):
    """`ClosedLoopAttackEnv` on drives without highway-env.

    Args:
        shared: The scenes, which others may share.
        planner: The car's planner.
        judge: One of these that is not played, which knows how drives end without an attack; None:
            this one drives them itself.
        given: The arguments of `ClosedLoopAttackEnv`.
    """

    def __init__(
        self,
        shared: SharedScenes,
        planner: Any,
        judge: LightClosedLoopAttackEnv | None,
        **given: Any,
    ) -> None:
        self._shared, self._planner, self._judge = shared, planner, judge
        super().__init__(**given)

    def _driven_by(self, perception: DrivePerception, **_: Any) -> LightClosedLoopEnv:
        seen = light_perception(perception, Motion.named(self._drives["motion"]))
        return LightClosedLoopEnv(self._shared, seen, self._planner)

    @property
    def unattacked(self) -> JudgedDrives:
        """The same drives without the attack."""
        return super().unattacked if self._judge is None else self._judge.unattacked

    @property
    def blind(self) -> JudgedDrives:
        """The same drives of a car that believes in no object."""
        return super().blind if self._judge is None else self._judge.blind


@takes_parts(Kind.ATTACK, refused=REFUSED, scenarios="drives", motion="truth")
class ClosedLoopAttackVectorEnv(ManyDrives[LightClosedLoopAttackEnv]):
    """`ClosedLoopAttackEnv` many times over; see there for the arguments.

    ``gym.make_vec("avsec/ClosedLoopAttack-v0", num_envs=64)`` makes it.  Attacks on what the car
    believes, perception by ``"truth"`` or an error model and recorded traffic are what it has.
    What else a single environment has is refused, and so are live attacks, which remember a drive.

    Raises:
        ConfigurationError: An argument is wrong, or one that only a single environment has.
    """

    title = "avsec/ClosedLoopAttack-v0"

    def __init__(
        self,
        num_envs: int = 1,
        kind: Any = "ghost",
        driver: Any = "planner",
        perception: Any = "truth",
        traffic: Any = RECORDED,
        duration: float = DURATION,
        frames: int = 20,
        energy: float = 15.0,
        price: float = 0.1,
        contested: bool = False,
        config: dict[str, Any] | None = None,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        taken = parts_of(self, parts)
        check_is_light(traffic, config, render_mode)
        count = checked_count(num_envs)
        if not isinstance(kind, str | Mapping):
            raise ConfigurationError(f"many drives at once name their attack: {ALONE}")
        made, planner = perception_of(perception, taken)
        light_perceptions(made, Motion.named(taken.motion), 1)
        given = {
            "kind": kind,
            "driver": driver,
            "duration": duration,
            "frames": frames,
            "energy": energy,
            "price": price,
            "contested": contested,
            **parts,
        }
        # One on highway-env is made first: it checks all arguments, and reads the scenes.
        first = ClosedLoopAttackEnv(perception=perception, **given)
        shared = SharedScenes(first.drive.scenes, first.drive.duration, PLACES)

        def alone(judge: LightClosedLoopAttackEnv | None) -> LightClosedLoopAttackEnv:
            own = given | {"perception": _another(made), "scenarios": shared.scenes}
            return LightClosedLoopAttackEnv(shared, planner, judge, **own)

        judge = alone(None)
        super().__init__([alone(judge) for _ in range(count)])


def _another(perception: Any) -> DrivePerception:
    """The same perception for another car: an error model remembers one drive."""
    if isinstance(perception, ErrorModelPerception):
        return ErrorModelPerception(perception.model)
    known: DrivePerception = perception
    return known
