"""Ghost-object attacks on a set of scenes: the rates without and with the attack.

Every scene and intention that is driven safely without an attack is attacked by `RandomGhosts`;
the others stay as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from avsec_gym.attacks.object_injection import RandomGhosts
from avsec_gym.boxes import Boxes3D
from avsec_gym.evaluation.rates import paired_json
from avsec_gym.metrics.paired import holm_p, paired_differences
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.progress import Progress, no_progress
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_set import SceneSet


@dataclass(frozen=True, eq=False)
class AttackedEpisode:
    """One scene and intention, without and with the attack."""

    scene: Scene
    intention: Intention
    clean: SafetyRecord
    attacked: SafetyRecord
    believed: Boxes3D
    """The last attacked detections."""
    queries: int


def ghost_attack(
    scenes: SceneSet,
    *,
    attack: RandomGhosts | None = None,
    intentions: Sequence[Intention] = tuple(Intention),
    on_progress: Progress = no_progress,
) -> list[AttackedEpisode]:
    """Attack every scene with every intention.

    Args:
        scenes: The scenes.
        attack: The attacker; None: two ghosts, ten queries.
        intentions: The driving intentions.
        on_progress: Function that gets the number of episodes that are done, and of all.
    """
    attack = RandomGhosts() if attack is None else attack
    planner, episodes = MotionPrimitivePlanner(), []
    total = len(scenes) * len(intentions)
    for turn, intention in enumerate(intentions):
        for scene in scenes.labelled:
            clean = run_episode(scene, intention, planner=planner).record
            attacked, believed, queries = clean, scene.boxes, 0
            if clean.safe:

                def query(
                    boxes: Boxes3D, scene: Scene = scene, intention: Intention = intention
                ) -> bool:
                    return not run_episode(scene, intention, boxes, planner=planner).record.safe

                seeds = (scene.seed, scene.number, turn)
                believed, queries = attack.attack(scene.boxes, query, seeds)
                attacked = run_episode(scene, intention, believed, planner=planner).record
            episodes.append(AttackedEpisode(scene, intention, clean, attacked, believed, queries))
            on_progress(len(episodes), total)
    return episodes


def summary(episodes: Sequence[AttackedEpisode]) -> dict[str, Any]:
    """Rates by intention and input, and their paired differences."""
    rates, pairs = [], {}
    for intention in dict.fromkeys(each.intention for each in episodes):
        own = [each for each in episodes if each.intention == intention]
        clean, attacked = [each.clean for each in own], [each.attacked for each in own]
        for name, records in (("ground_truth", clean), ("ghost_attack", attacked)):
            row = {"planner": "astar", "intention": str(intention), "input": name}
            rates.append({**row, **SafetyRates.of(records).to_json()})
        pairs[str(intention)] = paired_differences(clean, attacked)
    corrected = zip(pairs.items(), holm_p([*pairs.values()]), strict=True)
    differences = [
        {"intention": intention, **paired_json(paired), "mcnemar_p_holm": p}
        for (intention, paired), p in corrected
    ]
    return {"rates": rates, "differences": differences}
