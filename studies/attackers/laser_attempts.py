"""A laser that has one attempt at a scene: who aims, and what follows; in processes.

What `studies.attackers.quiet_laser` compares.
"""

from __future__ import annotations

import argparse
import multiprocessing
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, wait
from functools import cached_property
from typing import Any, NamedTuple

import cv2
import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import avsec_gym
from avsec_gym.attacks.facula import Facula
from avsec_gym.console import progress
from avsec_gym.envs.aimed_laser import ACTIONS, LASER, AimedLaser, full_light
from studies.attackers.arguments import given
from studies.attackers.searches import favourite, random_search
from studies.attackers.training import CountedQueries, trained

LEARNERS = ("sac", "cma_es", "random_search")
TRAINED = tuple(f"{how}_{who}" for who in LEARNERS for how in ("quiet", "loud"))
"""Each has as many attempts to learn from."""
BY_HAND = {f"by_hand_{radius}": full_light(radius) for radius in (22, 45, 90, 180)}
"""The attackers without learning: full light on the car's middle."""
DRAWN = ("random_shot", "thesis_facula")
ATTACKERS = (*TRAINED, *BY_HAND, *DRAWN)
"""Those who are trained take longest, and begin."""

Aim = Callable[[NDArray[Any]], NDArray[Any]]
"""A function from an observation to an action."""
Situation = tuple[str, str]
"""A scene's id and an intention."""


class AttemptOutcome(NamedTuple):
    """The result of an attempt."""

    unsafe: bool
    alarm: bool
    radius: float = 0.0
    strength: float = 0.0


def laser(options: argparse.Namespace, scenes: str) -> gym.Env[Any, Any]:
    """The environment; its detector and scenes are loaded when it is played."""
    gym.register_envs(avsec_gym)
    return gym.make(
        "avsec/FaculaAttack-v0",
        scenarios=contested(given(scenes)),
        detector=given(options.detector),
        score_threshold=options.threshold,
        validator={"name": "thresholds", "thresholds": options.table, "rate": options.rate},
        **LASER,
    )


def contested(scenes: Any) -> dict[str, Any]:
    """Those of some scenes, as they are named, in which something is in the way."""
    return {**(scenes if isinstance(scenes, dict) else {"source": scenes}), "contested": True}


def seeds_of(attacker: str, seeds: range) -> range:
    """What is aimed by hand needs but one."""
    return seeds[:1] if attacker in BY_HAND else seeds


def attempts(
    options: argparse.Namespace, situations: list[Situation], seeds: range
) -> dict[str, list[list[AttemptOutcome]]]:
    """The results of an attempt of every attacker, with every seed, in every situation."""
    tasks = [(name, seed) for name in ATTACKERS for seed in seeds_of(name, seeds)]
    total = len(tasks) * len(situations) + len(TRAINED) * len(seeds) * options.steps
    context = multiprocessing.get_context("spawn")
    fired = context.Value("i", 0)
    begin = (options, situations, fired)
    with (
        ProcessPoolExecutor(options.workers, context, _begin, begin) as pool,
        progress("attempts") as shown,
    ):
        jobs = {task: pool.submit(_outcomes, *task) for task in tasks}
        waiting = set(jobs.values())
        try:
            while waiting:
                done, waiting = wait(waiting, timeout=1.0)
                for job in done:
                    job.result()
                shown(min(fired.value, total), total)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return {
        name: [jobs[name, seed].result() for seed in seeds_of(name, seeds)] for name in ATTACKERS
    }


class _Range:
    """A process' scenes, which know how they are driven without an attack once they were played."""

    def __init__(
        self, options: argparse.Namespace, situations: list[Situation], tell: Callable[[], None]
    ) -> None:
        self.options, self.situations, self.tell = options, situations, tell

    @cached_property
    def training(self) -> AimedLaser:
        return AimedLaser(laser(self.options, self.options.training))

    @cached_property
    def held_out(self) -> AimedLaser:
        return AimedLaser(laser(self.options, self.options.testing))

    def outcomes(self, attacker: str, seed: int) -> list[AttemptOutcome]:
        generator = np.random.default_rng([seed, 1])  # Not the draws of the training.
        if attacker in TRAINED:
            aim = self._trained(attacker, seed)
        elif attacker in BY_HAND:
            aim = always(BY_HAND[attacker])
        else:
            aim = anywhere(generator)
        found = []
        for scene, intention in self.situations:
            options = {"scenario": scene, "intention": intention}
            if attacker == "thesis_facula":
                found.append(self._thesis(options, generator))
            else:
                seen, _ = self.held_out.reset(options=options)
                *_, info = self.held_out.step(aim(seen))
                spot = info["radius"], info["strength"]
                found.append(AttemptOutcome(not info["safe"], info["alarm"], *spot))
            self.tell()
        return found

    def _trained(self, attacker: str, seed: int) -> Aim:
        """Where it aims, after its attempts in the scenes for training."""
        how, _, who = attacker.partition("_")
        self.training.quiet = how == "quiet"
        counted = CountedQueries(self.training, self.options.steps, lambda *_: self.tell())
        if who == "sac":
            agent = trained(counted, self.options.steps, seed)
            return lambda seen: agent.predict(seen, deterministic=True)[0]
        found = favourite if who == "cma_es" else lambda *asked: random_search(*asked)[0]
        return always(found(counted, self.options.steps, seed))

    def _thesis(self, options: dict[str, str], generator: np.random.Generator) -> AttemptOutcome:
        """187 to 375 pixels, anywhere in either image."""
        played: Any = self.held_out.unwrapped
        game = played.game
        situation = game.draw(generator, options)
        facula = Facula(camera=int(generator.integers(2, 4)))
        tampered = facula.attack(situation.unattacked.frame, int(generator.integers(2**31)))
        look = game.query(situation, tampered.frame)
        spot = tampered.settings["radius"], facula.strength
        return AttemptOutcome(not look.episode.record.safe, look.report.alarm, *spot)


def always(action: NDArray[Any]) -> Aim:
    """The same spot at every car."""
    return lambda seen: action


def anywhere(generator: np.random.Generator) -> Aim:
    """A spot of its own at every car."""
    return lambda seen: generator.uniform(-1.0, 1.0, ACTIONS).astype(np.float32)


_RANGE: _Range
"""Where the attempts of a worker are made; see `_begin`."""


def _begin(options: argparse.Namespace, situations: list[Situation], fired: Any) -> None:
    def tell() -> None:
        with fired.get_lock():
            fired.value += 1

    global _RANGE
    cv2.setNumThreads(1)
    _RANGE = _Range(options, situations, tell)


def _outcomes(attacker: str, seed: int) -> list[AttemptOutcome]:
    return _RANGE.outcomes(attacker, seed)
