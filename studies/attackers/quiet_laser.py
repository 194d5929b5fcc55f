"""Train a laser to attack without an alarm, and see what that costs it in effect.

    python -m studies.attackers.quiet_laser
    python -m studies.attackers.quiet_laser --json > quiet_laser.json

A laser has one attempt at what is in the car's way, mostly a parked car, into one of the two
cameras: it chooses where beside the middle, how large a spot and how strong a light.  SAC learns it
twice: the quiet agent is paid for a plan that becomes unsafe while the validator raises no alarm,
the loud one for every plan that becomes unsafe; both pay a little for each attempt and for large
spots.  CMA-ES and random search learn one spot for all situations, with as many attempts and by
the same two rewards.  In held-out scenes they are compared with no attack, full light on the
middle at four radii, random spots of their own kind, and the thesis' facula (section 3.2.3), which
is larger, and anywhere in the image.

Rates are means over seeds, each of which is in `by_seed`.  Their 95 % intervals are Wilson's, of
situations that the seeds share; those of learners are widened by how much their trainings differ
(Student's t of the seeds' rates, both spreads squared and added).  `outcomes` lists
each of `situations`, by seed: `.` safe, `n` safe with an alarm, `U` unsafe, `N` unsafe with an
alarm.  `quiet_less_loud` is what the quiet reward costs in unsafe plans and gains in those without
an alarm, with Newcombe's intervals (1998), as if the two were of different situations.

Scenes to learn in, to be judged by, and to measure the validator's thresholds on are different
ones: in all of them something is in the way.  Those to be judged by are of the judging part of the
assets, with cars that the detector was not trained on, the others of the training part.  In about
half the car drives safely without an attack: of each of these one situation is played, whether or
not it raises an alarm by itself.

The scenes are rendered on first use, two seconds each; an attempt takes half a second, and two
processes attack: some 45 minutes of two cores in all.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.console import percent, print_table, progress
from avsec_gym.envs.aimed_laser import RADII, REACH, STRENGTHS
from avsec_gym.envs.sensor_attack_game import SensorAttackGame
from avsec_gym.evaluation.contested import contested_recipe
from avsec_gym.metrics.clustered_shares import (
    Share,
    difference_of_shares,
    share_of,
    share_of_trainings,
)
from avsec_gym.scenario.frame_scenes import FrameScenes, frame_scenes_of
from avsec_gym.scenario.intention import Intention
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitting import CleanFrames, fit_threshold_table
from avsec_gym.validation.recordings import RecordedFrame
from avsec_gym.validation.thresholds import ThresholdTable
from avsec_gym.world.assets import Assets
from avsec_gym.world.export import cached
from studies.attackers.arguments import arguments, given
from studies.attackers.laser_attempts import (
    ATTACKERS,
    LEARNERS,
    TRAINED,
    AttemptOutcome,
    Situation,
    attempts,
    laser,
)

TRAINING, HELD_OUT, CLEAN = 2001, 2002, 2003
"""Sets of layouts."""
ROWS = ("no_attack", *reversed(ATTACKERS))
RATES: dict[str, Callable[[AttemptOutcome], bool]] = {
    "unsafe": lambda outcome: outcome.unsafe,
    "alarm": lambda outcome: outcome.alarm,
    "unsafe_without_alarm": lambda outcome: outcome.unsafe and not outcome.alarm,
}


def compare(options: argparse.Namespace) -> dict[str, Any]:
    """Learn in some scenes, shoot in others."""
    begun = time.perf_counter()
    for name, frames, layouts, assets in (
        ("training", options.scenes, TRAINING, Assets.TRAIN),
        ("testing", options.held_out, HELD_OUT, Assets.JUDGE),
        ("clean", options.clean_scenes, CLEAN, Assets.TRAIN),
    ):
        if getattr(options, name) is None:
            setattr(options, name, rendered(frames, layouts, assets))
    if len({options.training, options.testing, options.clean}) < 3:
        raise SystemExit("--training, --testing and --clean are different scenes")
    table = measured(frame_scenes_of(given(options.clean)))
    with tempfile.TemporaryDirectory() as folder:
        options.table = str(Path(folder) / "thresholds.json")
        table.write(options.table)
        played: Any = laser(options, options.testing).unwrapped
        game = played.game
        clean, unsafe = unattacked(game, options.held_out, options.seed)
        if not clean:
            raise SystemExit("no held-out scene is driven safely by itself: raise --held-out")
        seeds = range(options.seed, options.seed + options.seeds)
        found = attempts(options, list(clean), seeds)
    rows = {"no_attack": [list(clean.values())], **found}
    return {
        "detector": given(options.detector),
        "false_alarm_rate": options.rate,
        "thresholds": asdict(*table.thresholds(options.rate).values()),
        "scenes": {
            "training": len(frame_scenes_of(given(options.training))),
            "thresholds": len(table),
        },
        "score_threshold": options.threshold,
        "radii": RADII,
        "strengths": STRENGTHS,
        "reach": REACH,
        "training_attempts": options.steps,
        "seeds": list(seeds),
        "situations": [" ".join(situation) for situation in clean],
        "scenes_unsafe_without_attack": unsafe,
        "attackers": {name: summary(rows[name], name in TRAINED) for name in ROWS},
        "quiet_less_loud": {
            who: differences(found[f"quiet_{who}"], found[f"loud_{who}"]) for who in LEARNERS
        },
        "minutes": round((time.perf_counter() - begun) / 60, 1),
    }


def rendered(frames: int, layouts: int, assets: Assets) -> str:
    """Scenes of a set, made of a part of the assets, in the cache."""
    recipe = contested_recipe(frames, seed=layouts, assets=assets)
    with progress("rendering scenes") as shown:
        return str(cached(f"contested-{layouts}-{frames}-{assets}", recipe, on_progress=shown))


def measured(clean: FrameScenes) -> ThresholdTable:
    """What the validator goes by."""
    scenes, data = clean.scenes.labelled, {"scenes": clean.scenes.name}
    frames = [RecordedFrame(scene.id, partial(clean.frame, scene)) for scene in scenes]
    with progress("measuring thresholds") as shown:
        return fit_threshold_table(
            CleanFrames(frames, LIDAR_AND_TWO_CAMERAS, PairDepth(), data), on_progress=shown
        )


def unattacked(
    game: SensorAttackGame, most: int, seed: int
) -> tuple[dict[Situation, AttemptOutcome], int]:
    """A situation of each scene that is driven safely, and of how many scenes none is."""
    generator = np.random.default_rng(seed)
    found: dict[Situation, AttemptOutcome] = {}
    unsafe = 0
    scenes = game.scenes.scenes.labelled[:most]
    with progress("held-out scenes without an attack") as shown:
        for done, scene in enumerate(scenes, start=1):
            order = map(Intention, generator.permutation(list(Intention)))
            played = [
                intention for intention in order if game.scenes.scenes.plays(scene.id, intention)
            ]
            looks = (
                (intention, game.situation(scene, intention).unattacked) for intention in played
            )
            safe = next(
                ((intention, look) for intention, look in looks if look.episode.record.safe), None
            )
            if safe is not None:
                found[scene.id, safe[0].value] = AttemptOutcome(False, safe[1].report.alarm)
            unsafe += bool(played) and safe is None
            shown(done, len(scenes))
    return found, unsafe


def summary(outcomes: list[list[AttemptOutcome]], trained: bool) -> dict[str, Any]:
    """Rates of the outcomes of each seed in each situation."""
    rates = {}
    for name, is_counted in RATES.items():
        flags = flags_of(outcomes, is_counted)
        share = share_of_trainings(flags) if trained else share_of_draws(flags)
        rates[name] = {
            "rate": round(float(flags.mean()), 4),
            "interval": [round(bound, 4) for bound in share.interval or (0.0, 1.0)],
            "by_seed": flags.mean(axis=1).round(4).tolist(),
        }
    fired = [outcome for seed in outcomes for outcome in seed]
    return rates | {
        "radius": round(float(np.mean([outcome.radius for outcome in fired])), 1),
        "strength": round(float(np.mean([outcome.strength for outcome in fired])), 1),
        "outcomes": ["".join(".nUN"[2 * each.unsafe + each.alarm] for each in s) for s in outcomes],
    }


def share_of_draws(flags: NDArray[Any]) -> Share:
    """The share of a rule, whose seeds share their situations, shape (seeds, situations)."""
    return share_of(flags.T, list(map(str, range(flags.shape[1]))))


def differences(
    first: list[list[AttemptOutcome]], second: list[list[AttemptOutcome]]
) -> dict[str, Any]:
    """First less second, of learners."""
    result = {}
    for name, is_counted in RATES.items():
        one, other = (
            share_of_trainings(flags_of(outcomes, is_counted)) for outcomes in (first, second)
        )
        found = difference_of_shares(one, other)
        result[name] = {
            "difference": round(found.value or 0.0, 4),
            "interval": [round(bound, 4) for bound in found.interval or (-1.0, 1.0)],
        }
    return result


def flags_of(
    outcomes: list[list[AttemptOutcome]], is_counted: Callable[[AttemptOutcome], bool]
) -> NDArray[Any]:
    """Shape (seeds, situations)."""
    return np.array([[is_counted(outcome) for outcome in seed] for seed in outcomes], bool)


def show(result: dict[str, Any]) -> None:
    """A table of the rates."""
    rows = []
    for name in ROWS:
        row = result["attackers"][name]
        rates = [percent(row[rate]["rate"], row[rate]["interval"]) for rate in RATES]
        spot = [f"{row['radius']:.0f}", f"{row['strength']:.0f}"]
        rows.append([name.replace("_", " "), *rates, *spot])
    title = f"{len(result['situations'])} drives that are safe without an attack; % (95 %)"
    heads = [*(rate.replace("_", " ") for rate in RATES), "radius (px)", "strength"]
    print_table(title, ["", *heads], rows)


def main() -> None:
    """Learn, compare, print."""
    parser = arguments((__doc__ or "").partition("\n")[0])
    # 256: eight generations of CMA-ES.
    own = {"detector": "stereo_rcnn", "steps": 256, "held_out": 120}
    parser.set_defaults(training=None, testing=None, **own)
    parser.add_argument("--scenes", type=int, default=60, help="to learn in, if rendered")
    parser.add_argument("--seeds", type=int, default=3, help="trainings of every agent")
    parser.add_argument("--clean", help="scenes that thresholds are measured on, as --training")
    parser.add_argument("--clean-scenes", type=int, default=200, help="of them, if rendered")
    parser.add_argument("--rate", type=float, default=0.01, help="designated false alarm rate")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--json", action="store_true", help="JSON instead of a table")
    options = parser.parse_args()
    result = compare(options)
    if options.json:
        sys.stdout.write(json.dumps(result, indent=1) + "\n")
    else:
        show(result)


if __name__ == "__main__":
    main()
