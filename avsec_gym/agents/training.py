"""Training an agent, in as many sittings as it takes."""

from __future__ import annotations

import platform
import time
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure

from avsec_gym.agents.agent_folder import (
    CARD,
    CONFIG,
    AgentCard,
    read_agent_card,
    read_configuration,
    save_agent,
    write_configuration,
)
from avsec_gym.agents.checkpoint import (
    CHECKPOINT,
    TrainingProgress,
    is_finite,
    read_checkpoint,
    write_checkpoint,
)
from avsec_gym.agents.configuration import AgentConfiguration, naming_the_file
from avsec_gym.agents.environment_networks import (
    all_weights,
    environment_networks,
    report_other_weights,
)
from avsec_gym.agents.learner import make_learner, single
from avsec_gym.command_line import command_line
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.progress import Progress, no_progress
from avsec_gym.storage.folder_lock import locked_folder
from avsec_gym.storage.regular_files import is_there

TENSORBOARD = "tensorboard"
"""The folder of its files in that of an agent."""
_SECONDS_BETWEEN_CHECKPOINTS = 60.0


@dataclass(frozen=True)
class TrainingSitting:
    """What to do in one sitting.

    Args:
        steps: Environment steps to have learned from in the end, all sittings together.
        minutes: Time of this sitting, after which the rollout in hand is learned from; None: as
            long as it takes.
        resume: Whether to go on with what is there.
        threads: Threads of the processor.
    """

    steps: int
    minutes: float | None = None
    resume: bool = False
    threads: int = 1


def train_agent(
    configuration: AgentConfiguration,
    out: Path,
    seed: int,
    sitting: TrainingSitting,
    on_progress: Progress = no_progress,
) -> AgentCard:
    """Train, or go on training; the folder holds the agent then, finished or not.

    A training that is stopped in any way goes on from its last checkpoint, a minute old at most;
    Ctrl-C leaves one of the rollout before.  Where it goes on against other weights of a network,
    that is logged, and the card has both.

    Args:
        configuration: How it learns.
        out: The agent's folder.
        seed: Seed of weights, exploration and environments.
        sitting: How long.
        on_progress: Function that gets steps done and steps in all.

    Returns:
        The card, without a held-out result.

    Raises:
        ConfigurationError: The configuration does not fit the environment, or the training has
            diverged.
        DataError: Something else is in the folder, or what is there cannot be gone on with; or the
            configuration is of a user's file and does not fit.
    """
    with locked_folder(out):
        begun = _check_folder(configuration, out, seed, sitting.resume)
        torch.set_num_threads(sitting.threads)
        with naming_the_file(configuration):
            # Before the learner sets the seed: networks draw their first weights.
            networks = _networks(configuration, out, begun)
            learner = make_learner(configuration, seed)
        before = read_checkpoint(out, learner) if begun else TrainingProgress()
        if not begun:
            write_configuration(out, configuration, seed)
        _log_to_tensorboard(learner, out)
        watch = _Watch(out, before, sitting, on_progress)
        if before.steps < sitting.steps:
            try:
                with naming_the_file(configuration):
                    learner.learn(
                        sitting.steps - before.steps,
                        callback=watch,
                        reset_num_timesteps=before.steps == 0,
                    )
            except ValueError as error:
                # torch refuses distributions with weights that have grown beyond all numbers.
                if is_finite(learner):
                    raise
                raise _diverged(out, watch.progress) from error
            finally:
                # Also after Ctrl-C: what was learned is kept.
                if is_finite(learner):
                    write_checkpoint(out, learner, watch.progress)
            if not is_finite(learner):
                raise _diverged(out, watch.progress)
        learner.env.close()
        card = _card(configuration, seed, sitting, watch.progress)
        return save_agent(out, learner.policy, replace(card, networks=networks))


class _Watch(BaseCallback):
    """Counts what was learned from, writes checkpoints, and ends a sitting between two rollouts."""

    def __init__(
        self,
        out: Path,
        before: TrainingProgress,
        sitting: TrainingSitting,
        on_progress: Progress,
    ) -> None:
        super().__init__()
        self._out, self._before, self._sitting, self._on_progress = (
            out,
            before,
            sitting,
            on_progress,
        )
        self._begun = self._written = time.monotonic()
        self.progress = before

    def _on_rollout_start(self) -> None:
        # All steps so far have been learned from: a training can go on from here.
        self._note()
        due = time.monotonic() - self._written > _SECONDS_BETWEEN_CHECKPOINTS
        if due and is_finite(self.model):
            write_checkpoint(self._out, self.model, self.progress)
            self._written = time.monotonic()

    def _on_step(self) -> bool:
        self._on_progress(min(self.num_timesteps, self._sitting.steps), self._sitting.steps)
        first = self.num_timesteps <= self.progress.steps + self.training_env.num_envs
        return not (first and self._time_is_up())

    def _on_training_end(self) -> None:
        if not self._time_is_up() or self.num_timesteps >= self._sitting.steps:
            self._note()

    def _time_is_up(self) -> bool:
        minutes = self._sitting.minutes
        return minutes is not None and time.monotonic() - self._begun > 60.0 * minutes

    def _note(self) -> None:
        seconds = self._before.seconds + time.monotonic() - self._begun
        self.progress = TrainingProgress(int(self.num_timesteps), seconds)


def _log_to_tensorboard(learner: Any, out: Path) -> None:
    """What stable-baselines3 reports of a training goes to TensorBoard, if it is installed.

    Rewards, success rates and lengths of episodes, losses, steps a second; each sitting has a file
    of its own, counted in steps of the whole training.
    """
    if find_spec("tensorboard") is not None:
        learner.set_logger(configure(str(out / TENSORBOARD), ["tensorboard"]))


def _diverged(out: Path, progress: TrainingProgress) -> ConfigurationError:
    return ConfigurationError(
        f"the training in {out} has diverged after {progress.steps:,} steps or a little later:"
        " weights are not finite any more; give a lower learning_rate, or a max_grad_norm"
    )


def _check_folder(configuration: AgentConfiguration, out: Path, seed: int, resume: bool) -> bool:
    """Whether a training has begun in a folder.

    Raises:
        DataError: It has and is not to be gone on with, or it is another one.
    """
    if not is_there(out / CONFIG):
        return False
    if not resume:
        raise DataError(
            "There is an agent here already.",
            path=out,
            remedy="Go on with it by --resume, or name another --out.",
        )
    there, its_seed = read_configuration(out)
    own, asked = there.entry(), configuration.entry()
    pairs = {
        "env": (there.env, configuration.env),
        "algorithm": (there.algorithm, configuration.algorithm),
        "seed": (its_seed, seed),
        **{name: (own.get(name), asked.get(name)) for name in sorted({*own, *asked})},
    }
    # How long is asked anew in each sitting.
    different = [name for name, (a, b) in pairs.items() if a != b and name != "n_timesteps"]
    if different:
        raise DataError(
            f"Another training is here: it differs in {', '.join(different)}.",
            path=out / CONFIG,
            remedy="Ask for the same one, or name another --out.",
        )
    return is_there(out / CHECKPOINT)


def _networks(configuration: AgentConfiguration, out: Path, begun: bool) -> dict[str, list[str]]:
    """The weights that the agent has been trained against after this sitting."""
    environment = single(configuration.env, configuration.env_kwargs)
    today = environment_networks(environment)
    environment.close()
    # A sitting that was stopped by Ctrl-C leaves no card.
    there = begun and is_there(out / CARD)
    before = read_agent_card(out).networks if there else {}
    report_other_weights(str(out), before, today)
    return all_weights(before, today)


def _card(
    configuration: AgentConfiguration,
    seed: int,
    sitting: TrainingSitting,
    progress: TrainingProgress,
) -> AgentCard:
    from importlib.metadata import version

    from avsec_gym import __version__

    names = ("stable-baselines3", "torch", "gymnasium", "numpy")
    own: dict[str, Any] = {name: version(name) for name in names}
    return AgentCard(
        env=configuration.env,
        env_kwargs=configuration.env_kwargs,
        eval_env_kwargs=configuration.eval_env_kwargs,
        algorithm=configuration.algorithm,
        seed=seed,
        steps=progress.steps,
        seconds=round(progress.seconds, 1),
        finished=progress.steps >= sitting.steps,
        parameters=0,
        sha256="",
        versions={"avsec_gym": __version__, "python": platform.python_version(), **own},
        command=command_line(),
    )
