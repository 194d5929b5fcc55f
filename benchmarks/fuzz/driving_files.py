"""What `avsec drive`, `avsec agents` and the benchmark keep, sound, and as they read it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

AGENT_ENVIRONMENT = "avsec/GhostObject-v0"
CONFIGURATION = """# A comment.
avsec/GhostObject-v0:
  n_envs: 2
  n_timesteps: !!float 1e3
  policy: 'MlpPolicy'
  learning_rate: lin_3e-4
  learning_starts: 8
  buffer_size: 60
  batch_size: 8
  train_freq: [1, step]
  ent_coef: auto
  use_sde: false
  policy_kwargs: "dict(net_arch=dict(pi=[8], qf=[8]), activation_fn=nn.Tanh)"
  env_kwargs: {scenarios: {name: layouts, seed: 0, count: 3}, ghosts: 2}
  eval_env_kwargs: {scenarios: {name: layouts, seed: 7, count: 3}}
"""
_RECORD = {"version": "1", "seed": 0, "settings": {"truth": {}, "blind": {"perception": "blind"}}}


def agent_configuration(folder: Path) -> None:
    """A file for `--config`."""
    (folder / "sac.yml").write_text(CONFIGURATION)


def read_agent_configuration(folder: Path) -> Any:
    """As `avsec agents train --config` does, until it would learn."""
    from avsec_gym.agents.configuration import configuration_of, naming_the_file
    from avsec_gym.agents.learner import make_learner

    configuration = configuration_of(AGENT_ENVIRONMENT, "sac", folder / "sac.yml")
    with naming_the_file(configuration):
        make_learner(configuration, 0).learn(16)
    return configuration.entry()


def agent(folder: Path) -> None:
    """An agent that has begun to learn."""
    from avsec_gym.agents.configuration import configuration_of
    from avsec_gym.agents.training import TrainingSitting, train_agent

    agent_configuration(folder)
    configuration = configuration_of(AGENT_ENVIRONMENT, "sac", folder / "sac.yml")
    train_agent(configuration, folder / "agent", 0, TrainingSitting(16))


def read_agent(folder: Path) -> Any:
    """As `avsec agents evaluate` does: loaded, and asked for an action."""
    from avsec_gym.agents.agent_folder import load_agent
    from avsec_gym.agents.learner import single
    from avsec_gym.errors import ConfigurationError, DataError

    try:
        found = load_agent(folder / "agent")
        environment = single(found.configuration.env, found.configuration.held_out_kwargs)
    except ConfigurationError as error:
        raise DataError(str(error), path=folder / "agent") from None
    observation, _ = environment.reset(seed=0)
    environment.step(found.predict(observation)[0])
    return found.card, found.configuration.entry(), found.policy.state_dict()


def read_training(folder: Path) -> Any:
    """As `avsec agents train --resume` does: gone on with for a few steps."""
    from avsec_gym.agents.configuration import configuration_of
    from avsec_gym.agents.training import TrainingSitting, train_agent

    configuration = configuration_of(AGENT_ENVIRONMENT, "sac", folder / "sac.yml")
    return train_agent(configuration, folder / "agent", 0, TrainingSitting(20, resume=True))


def drives(folder: Path) -> None:
    """Two drives of one scene under two settings."""
    from avsec_gym.drives.drive_folder import DriveFolder
    from avsec_gym.drives.one_drive import Driven

    found = DriveFolder(folder, _RECORD)
    for setting, outcome in (("truth", "goal"), ("blind", "collision")):
        bad = outcome == "collision"
        row = {
            "id": f"{setting}/a/left", "setting": setting, "scenario": "a", "intention": "left",
            "seed": 0, "steps": 20, "duration": 2.0, "outcome": outcome, "at_fault": bad,
            "collision": bad, "safe": not bad, "path_length": 15.1, "progress": 15.1,
            "smallest_distance": None if bad else 8.6, "time_to_collision": None,
            "cost_sm1": 487.2, "navsim_score": 0.83, "no_collision": 1.0, "drivable": 1.0,
            "ttc_bound": 1.0, "progress_share": 1.0, "comfort": 0.0, "touched": "",
            "hardest_braking": 0.0, "emergency_stops": 0, "alarms": 0, "first_plan": "safe",
        }  # fmt: skip
        found.add(Driven(row, _film(), 0.5, {}))


def read_drives(folder: Path) -> Any:
    """As `avsec drive --resume` does: the table, the page with its strips, the clip."""
    from avsec_gym.drawing.film_strip import clip, gif
    from avsec_gym.drives.drive_folder import DriveFolder
    from avsec_gym.drives.scene_figures import shown_drives
    from avsec_gym.drives.summary import summaries
    from avsec_gym.drives.telling import by_scene
    from avsec_gym.report.drives_page import drives_page

    found = DriveFolder(folder, _RECORD)
    summary = summaries(found.rows.values(), ["truth", "blind"])
    films = [found.film(id) for id in found.rows]
    if summary:
        drives_page(found, summary, _RECORD, 1)
        gif(clip(shown_drives(found, by_scene(found.rows.values())[0])))
    return found.rows, found.seconds, films


def frozen_labels(path: Path) -> None:
    """What the benchmark's version holds of the labelled KITTI scenarios: the package's own."""
    from avsec_gym.benchmark import kitti_scenes

    path.write_bytes(Path(kitti_scenes.__file__).with_name(kitti_scenes.FROZEN).read_bytes())


def read_frozen_labels(folder: Path) -> Any:
    """As an entry of a detector's results does: the digest, and what is to be found where."""
    from avsec_gym.benchmark.kitti_scenes import read_frozen_labels

    frozen = read_frozen_labels(folder / "kitti_1.json")
    assert len(frozen.digest) == 16
    return frozen


def _film() -> Any:
    """Two seconds straight ahead; one actor ahead."""
    from avsec_gym.closed_loop.drive_film import DriveFilm

    times = np.arange(21) / 10
    car = np.zeros((21, 5))
    car[:, 0], car[:, 2] = 10.0 * times, 10.0
    poses = np.zeros((21, 1, 3))
    poses[:, 0, 0] = 30.0
    side = np.array([[-50.0, 2.0], [100.0, 2.0]])
    return DriveFilm(
        times=times, car=car, braking=np.zeros(21), ways=np.zeros(21),
        sizes=np.array([[4.0, 2.0]]), poses=poses, present=np.ones((21, 1), bool),
        believed=np.array([[30.0, 0.0, 0.0, 4.0, 2.0]]), believed_at=np.array([0]),
        plans=np.column_stack([np.arange(30.0), np.zeros(30)]), plan_of=np.zeros(30, int),
        planned=np.zeros(21, int), stops=np.zeros(21, bool),
        bounds=np.vstack([side, side * (1, -1)]), bound_of=np.array([0, 0, 1, 1]),
        goal=np.array([[40.0, 2.0], [40.0, -2.0]]), contact=np.array([-1]),
    )  # fmt: skip
