"""Which detector lets the car drive most safely?  Ranks detectors by `evaluate_policy`.

    python -m studies.perception.detector_ranking [--detectors oracle dsgn] [--episodes 96]

Beside the given detectors it ranks an empty one (an agent that never reports anything), and with
``--replayed FOLDER`` the KITTI result files of another detector.  The scenes are those of the suite
`mixed`, with cars that no detector was trained on.  Prints JSON.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from typing import Any

import gymnasium as gym
import numpy as np
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor

import avsec_gym
from avsec_gym.boxes import Boxes3D
from avsec_gym.commands.named_part import named_part
from avsec_gym.envs.detector_policy import DetectorPolicy
from avsec_gym.frame import SensorFrame
from avsec_gym.metrics.clustered_shares import share_of


class EmptyDetector:
    """Sees nothing at all: what safety is worth without perception."""

    name = "nothing"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """No boxes."""
        return Boxes3D.empty()


def ranked(detector: Any, scenarios: Any, episodes: int) -> dict[str, Any]:
    """One row: the share of safe plans over seeded episodes, the same for every detector."""
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
    safe = share_of(np.array(rewards) > 0, [info["scenario"] for info in outcomes])
    objects = sum(info["objects"] for info in outcomes)
    return {
        "detector": policy.detector.name,
        "safe_driving_rate": round(safe.count / episodes, 4),
        "interval": [round(bound, 4) for bound in safe.interval or ()],
        "collisions": sum(info["collision"] for info in outcomes),
        "unplanned": sum(not info["planned"] for info in outcomes),
        "found": round(sum(info["found"] for info in outcomes) / max(objects, 1), 4),
        "seconds_per_episode": round((time.perf_counter() - begun) / episodes, 3),
    }


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
    parser.add_argument("--episodes", type=int, default=96)
    options = parser.parse_args()
    gym.register_envs(avsec_gym)
    every: list[Any] = [*options.detectors, EmptyDetector()]
    if options.replayed:
        every.append({"name": "replayed", "detections": options.replayed})
    scenarios = named_part(options.scenarios, "--scenarios")
    rows = [ranked(detector, scenarios, options.episodes) for detector in every]
    rows.sort(key=lambda row: -row["safe_driving_rate"])
    sys.stdout.write(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
