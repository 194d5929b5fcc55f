"""Train a laser to stay unnoticed, and see what that costs it in effect.

    python examples/train_quiet_laser.py
    python examples/train_quiet_laser.py --json > quiet_laser.json

A laser has one shot at a scene, into one of the two cameras.  SAC is trained twice with as many
shots: the quiet agent is paid for a drive that becomes unsafe while the validator raises no alarm,
the loud one for every drive that becomes unsafe.  On held-out scenes both are compared with no
attack, the thesis' facula (section 3.2.3), and random shots of their own kind: small, and beside
the nearest car, at which all but the thesis' aim.  Rates are means over seeds, each of which is in
`by_seed`; the intervals are Wilson's, of as many cases as there are situations.

The scenes that the agents are trained on, those that they are judged by, and those that the
validator's thresholds are measured on, the suite `mixed`, are different ones.  Of the first two, in
all of which a car is in the way, about half are driven safely without an attack: of each of these
one situation is played, whether or not it raises an alarm by itself.

The scenes are rendered on first use, two seconds each; a shot takes half a second, and two
processes shoot: about 17 minutes of two cores in all.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np
from contested_frames import contested_frames
from laser_shots import SHOOTERS, Outcome, Situation, laser, shots
from train_perturbation_attacker import arguments, given

from avsec_gym.commands.console import percent, print_json, print_table, progress
from avsec_gym.envs.game_validator import CLEAN
from avsec_gym.envs.sensor_attack_game import SensorAttackGame
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.scenario.frame_scenes import frame_scenes_of
from avsec_gym.scenario.intention import Intention

TRAINING, HELD_OUT = 2001, 2002
"""Sets of layouts."""
ROWS = ("no_attack", *reversed(SHOOTERS))
RATES = ("unsafe", "noticed", "unsafe_and_unnoticed")


def compare(options: argparse.Namespace) -> dict[str, Any]:
    """Train in some scenes, shoot in others."""
    begun = time.perf_counter()
    if options.training is None:
        options.training = rendered(options.scenes, TRAINING)
    if options.testing is None:
        options.testing = rendered(options.held_out, HELD_OUT)
    game = laser(options, options.testing).unwrapped.game
    clean, unsafe = unattacked(game, options.held_out, options.seed)
    if not clean:
        raise SystemExit("no held-out scene is driven safely without an attack: raise --held-out")
    seeds = range(options.seed, options.seed + options.seeds)
    found = shots(options, list(clean), seeds)
    rows = {name: summary([found[name, seed] for seed in seeds]) for name in reversed(SHOOTERS)}
    return {
        "detector": given(options.detector),
        "false_alarm_rate": options.rate,
        "scenes": {
            "training": len(frame_scenes_of(given(options.training))),
            "thresholds": min(CLEAN, len(frame_scenes_of(given(options.clean)))),
        },
        "training_shots": options.steps,
        "seeds": list(seeds),
        "situations": len(clean),
        "scenes_unsafe_without_attack": unsafe,
        "no_attack": summary([list(clean.values())]),
        **rows,
        "minutes": round((time.perf_counter() - begun) / 60, 1),
    }


def rendered(frames: int, seed: int) -> str:
    """Scenes of a set, in the cache."""
    with progress("rendering scenes") as shown:
        return str(contested_frames(frames, seed, shown))


def unattacked(
    game: SensorAttackGame, most: int, seed: int
) -> tuple[dict[Situation, Outcome], int]:
    """A situation of each scene that is driven safely, and of how many scenes none is."""
    generator = np.random.default_rng(seed)
    found: dict[Situation, Outcome] = {}
    unsafe = 0
    scenes = game.scenes.scenes.labelled[:most]
    with progress("held-out scenes without an attack") as shown:
        for done, scene in enumerate(scenes, start=1):
            order = map(Intention, generator.permutation(list(Intention)))
            played = [one for one in order if not game.contested or game.is_contested(scene, one)]
            looks = ((one, game.situation(scene, one).unattacked) for one in played)
            safe = next(((one, look) for one, look in looks if look.drive.record.safe), None)
            if safe is not None:
                found[scene.id, safe[0].value] = False, safe[1].notice.alarm, 0.0
            unsafe += bool(played) and safe is None
            shown(done, len(scenes))
    return found, unsafe


def summary(outcomes: list[list[Outcome]]) -> dict[str, Any]:
    """Rates of the outcomes of each seed in each situation."""
    unsafe, noticed, radius = np.moveaxis(np.array(outcomes, float), 2, 0)
    rates = map(rate, (unsafe, noticed, unsafe * (1 - noticed)))
    return dict(zip(RATES, rates, strict=True)) | {"radius": round(float(radius.mean()), 1)}


def rate(flags: np.ndarray) -> dict[str, Any]:
    """Of flags of shape (seeds, situations), with its 95 % interval."""
    mean, cases = float(flags.mean()), flags.shape[1]
    low, high = wilson_interval(mean * cases, cases)
    return {
        "rate": round(mean, 4),
        "interval": [round(low, 4), round(high, 4)],
        "by_seed": flags.mean(axis=1).round(4).tolist(),
    }


def show(result: dict[str, Any]) -> None:
    """A table of the rates."""
    rows = []
    for name in ROWS:
        row = result[name]
        rates = [percent(row[one]["rate"], row[one]["interval"]) for one in RATES]
        rows.append([name.replace("_", " "), *rates, f"{row['radius']:.0f}"])
    title = f"{result['situations']} drives that are safe without an attack; % (95 %)"
    print_table(title, ["", *(one.replace("_", " ") for one in RATES), "radius (px)"], rows)


def main() -> None:
    """Train, compare, tell."""
    parser = arguments(__doc__.splitlines()[0])
    own = {"detector": "stereo_rcnn", "steps": 300, "held_out": 120}
    parser.set_defaults(training=None, testing=None, **own)
    parser.add_argument("--scenes", type=int, default=60, help="to train on, where rendered")
    parser.add_argument("--seeds", type=int, default=3, help="trainings of either agent")
    parser.add_argument("--clean", default="mixed", help="scenes that thresholds are measured on")
    parser.add_argument("--rate", type=float, default=0.05, help="designated false alarm rate")
    parser.add_argument(
        "--all-scenes", action="store_true", help="also where nothing is in the way"
    )
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--json", action="store_true", help="JSON instead of a table")
    options = parser.parse_args()
    result = compare(options)
    (print_json if options.json else show)(result)


if __name__ == "__main__":
    main()
