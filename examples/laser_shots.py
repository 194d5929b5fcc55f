"""A laser that has one shot at a scene: who shoots, where, and what comes of it; in processes.

What `train_quiet_laser.py` compares.
"""

from __future__ import annotations

import argparse
import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, wait
from functools import cached_property
from typing import Any

import cv2
import gymnasium as gym
import numpy as np
from train_perturbation_attacker import Watched, given, train

import avsec_gym
from avsec_gym.attacks.facula import Facula
from avsec_gym.commands.console import progress

REACH = 0.25
"""How far beside the nearest car a laser aims, as a share of half the image."""
RADII = (30.0, 180.0)
"""Pixels: the smallest hides hardly a car, the largest is noticed always."""
NEAREST = slice(9 + 8, 9 + 8 + 2)
"""Of the observation: column and row of the nearest car's place on the road.  Before them are 9
figures of start and goal, and 8 of that car (`avsec_gym.envs.sensor_attack_features.features`)."""
TRAINED = ("quiet_sac", "loud_sac")
SHOOTERS = (*TRAINED, "random_shot", "thesis_facula")
"""Those who are trained take longest, and begin."""

Situation = tuple[str, str]
"""A scene's id and an intention."""
Outcome = tuple[bool, bool, float]
"""Whether the drive is unsafe, whether the attack was noticed, and the facula's radius."""


class Aimed(gym.Wrapper):
    """One shot an episode; actions: camera, columns and rows from the nearest car, radius."""

    quiet = True
    """False: an unsafe drive is paid for whether or not the validator noticed why."""

    def reset(self, **options: Any) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin, and see where the nearest car is."""
        observation, info = self.env.reset(**options)
        self._place = observation[NEAREST].copy()
        return observation, info

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Shoot."""
        beside = np.clip(self._place + REACH * action[1:3], -1.0, 1.0)
        shot = np.array([action[0], *beside, action[3]], np.float32)
        observation, reward, _, _, info = self.env.step(shot)
        if not self.quiet and info["noticed"] and not info["safe"]:
            reward = float(reward) + 1.0
        return observation, float(reward), True, False, info


def laser(options: argparse.Namespace, scenes: str) -> gym.Env:
    """The environment; its detector and scenes are loaded when it is played."""
    gym.register_envs(avsec_gym)
    return gym.make(
        "avsec/FaculaAttack-v0",
        scenarios=given(scenes),
        detector=given(options.detector),
        score_threshold=options.threshold,
        validator={"name": "thresholds", "rate": options.rate},
        clean=given(options.clean),
        contested=not options.all_scenes,
        radii=RADII,
    )


def shots(
    options: argparse.Namespace, situations: list[Situation], seeds: range
) -> dict[tuple[str, int], list[Outcome]]:
    """What comes of a shot of every shooter, with every seed, in every situation."""
    tasks = [(name, seed) for name in SHOOTERS for seed in seeds]
    total = len(tasks) * len(situations) + len(TRAINED) * len(seeds) * options.steps
    context = multiprocessing.get_context("spawn")
    fired = context.Value("i", 0)
    begin = (options, situations, fired)
    with (
        ProcessPoolExecutor(options.workers, context, _begin, begin) as pool,
        progress("shots") as shown,
    ):
        jobs = {task: pool.submit(_outcomes, *task) for task in tasks}
        waiting = set(jobs.values())
        try:
            while waiting:
                done, waiting = wait(waiting, timeout=1.0)
                for job in done:
                    job.result()
                shown(fired.value, total)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return {task: job.result() for task, job in jobs.items()}


class _Range:
    """A process' scenes, which know how they are driven without an attack once they were played."""

    def __init__(
        self, options: argparse.Namespace, situations: list[Situation], tell: Callable[[], None]
    ) -> None:
        self.options, self.situations, self.tell = options, situations, tell

    @cached_property
    def training(self) -> Aimed:
        return Aimed(laser(self.options, self.options.training))

    @cached_property
    def held_out(self) -> Aimed:
        return Aimed(laser(self.options, self.options.testing))

    def outcomes(self, shooter: str, seed: int) -> list[Outcome]:
        generator = np.random.default_rng([seed, 1])  # Not the draws of the training.
        agent: Any = None
        if shooter in TRAINED:
            self.training.quiet = shooter == "quiet_sac"
            counted = Watched(self.training, self.options.steps, lambda *_: self.tell())
            agent = train(counted, self.options.steps, seed)
        found = []
        for scene, intention in self.situations:
            options = {"scenario": scene, "intention": intention}
            if shooter == "thesis_facula":
                found.append(self._thesis(options, generator))
            else:
                seen, _ = self.held_out.reset(options=options)
                action = generator.uniform(-1.0, 1.0, 4).astype(np.float32)
                if agent is not None:
                    action = agent.predict(seen, deterministic=True)[0]
                *_, info = self.held_out.step(action)
                found.append((not info["safe"], info["noticed"], info["radius"]))
            self.tell()
        return found

    def _thesis(self, options: dict[str, str], generator: np.random.Generator) -> Outcome:
        """187 to 375 pixels, anywhere in either image."""
        game = self.held_out.unwrapped.game
        situation = game.draw(generator, options)
        facula = Facula(camera=int(generator.integers(2, 4)))
        tampered = facula.attack(situation.unattacked.frame, int(generator.integers(2**31)))
        look = game.query(situation, tampered.frame)
        return not look.drive.record.safe, look.notice.alarm, tampered.settings["radius"]


def _begin(options: argparse.Namespace, situations: list[Situation], fired: Any) -> None:
    def tell() -> None:
        with fired.get_lock():
            fired.value += 1

    global _RANGE
    cv2.setNumThreads(1)
    _RANGE = _Range(options, situations, tell)


def _outcomes(shooter: str, seed: int) -> list[Outcome]:
    return _RANGE.outcomes(shooter, seed)
