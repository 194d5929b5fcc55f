"""Which detector lets the car drive most safely?  Ranks detectors by `evaluate_policy`.

    python -m studies.perception.detector_ranking [--detectors oracle dsgn] [--episodes 96]

Beside the given detectors it ranks an empty one (an agent that never reports anything), and with
``--replayed FOLDER`` the KITTI result files of another detector.  The scenes are those of the suite
`mixed`, with cars that no detector was trained on; with ``--contested`` those of `mixed_contested`.
All play the same episodes: each is compared with the one behind it.  Prints JSON.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor

import avsec_gym
from avsec_gym.boxes import Boxes3D
from avsec_gym.commands.named_part import named_part
from avsec_gym.envs.detector_policy import DetectorPolicy
from avsec_gym.frame import SensorFrame
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.metrics.paired_scores import paired_difference


class EmptyDetector:
    """Sees nothing at all: what safety is worth without perception."""

    name = "nothing"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """No boxes."""
        return Boxes3D.empty()


@dataclass(frozen=True)
class Ranked:
    """A detector's episodes.

    Args:
        row: Its rates.
        safe: Whether each plan was safe, shape (N,).
        scenes: The scene of each.
    """

    row: dict[str, Any]
    safe: NDArray[np.bool_]
    scenes: list[str]


def ranked(detector: Any, scenarios: Any, episodes: int) -> Ranked:
    """The share of safe plans over seeded episodes, the same for every detector."""
    env = gym.make("avsec/DetectorBenchmark-v0", scenarios=scenarios)
    policy = DetectorPolicy(detector, env)
    env.reset(seed=0)
    outcomes: list[dict[str, Any]] = []
    begun = time.perf_counter()
    rewards, _ = evaluate_policy(
        policy,  # type: ignore[arg-type]
        Monitor(env),
        n_eval_episodes=episodes,
        return_episode_rewards=True,
        callback=lambda local, _: outcomes.append(dict(local["info"])),
    )
    # Plans in one scene, with other intentions, are alike: they widen the interval.
    safe, scenes = np.array(rewards) > 0, [str(info["scenario"]) for info in outcomes]
    share = share_of(safe, scenes)
    objects = sum(info["objects"] for info in outcomes)
    row = {
        "detector": policy.detector.name,
        "safe_driving_rate": round(share.count / episodes, 4),
        "interval": [round(bound, 4) for bound in share.interval or ()],
        "collisions": sum(info["collision"] for info in outcomes),
        "unplanned": sum(not info["planned"] for info in outcomes),
        "found": round(sum(info["found"] for info in outcomes) / max(objects, 1), 4),
        "seconds_per_episode": round((time.perf_counter() - begun) / episodes, 3),
    }
    return Ranked(row, safe, scenes)


def compared(every: list[Ranked]) -> list[dict[str, Any]]:
    """The rows from the safest to the least safe, each with its lead on the one behind it."""
    order = sorted(every, key=lambda one: -one.row["safe_driving_rate"])
    leads: list[dict[str, Any]] = []
    for one, behind in pairwise(order):
        lead = paired_difference(one.safe, behind.safe, one.scenes)
        bounds = [round(bound, 4) for bound in lead.interval or ()]
        leads.append({"lead": round(lead.difference, 4), "lead_interval": bounds})
    return [one.row | lead for one, lead in zip(order, [*leads, {}], strict=True)]


def main() -> None:
    """Rank, print JSON."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--detectors", nargs="*", default=["oracle", "dsgn", "stereo_rcnn"])
    parser.add_argument("--replayed", help="a folder of KITTI result files")
    parser.add_argument(
        "--scenarios",
        default=json.dumps({"source": "mixed", "assets": "judge"}),
        help="a default suite, a KITTI folder, or JSON",
    )
    parser.add_argument(
        "--contested",
        action="store_const",
        dest="scenarios",
        const=json.dumps({"source": "mixed_contested", "assets": "judge"}),
        help="scenes in which a car that believes in nothing drives unsafely",
    )
    parser.add_argument("--episodes", type=int, default=96)
    options = parser.parse_args()
    gym.register_envs(avsec_gym)
    every: list[Any] = [*options.detectors, EmptyDetector()]
    if options.replayed:
        every.append({"name": "replayed", "detections": options.replayed})
    scenarios = named_part(options.scenarios, "--scenarios")
    rows = compared([ranked(detector, scenarios, options.episodes) for detector in every])
    sys.stdout.write(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
