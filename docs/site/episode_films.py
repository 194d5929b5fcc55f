"""Films of episodes, one for each environment, rendered once and kept beside the build.

The scenes are few and made here, so that no default suite has to be rendered for them.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from PIL import Image

import avsec_gym
from avsec_gym.agents.agent_folder import load_agent
from avsec_gym.envs.detector_policy import DetectorPolicy
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.registration import CATALOGUE
from avsec_gym.world.export import make_data_set, suite_recipe

FILM, STILL, FACTS = ".webp", "_still.webp", ".txt"
"""Ends of the files of a film: moving, its last picture, its caption."""
WIDTH = 720
TRIES = 5
"""Seeds, until the agent succeeds."""
FRAMES = {"mixed": 6, "raw": 4, "connected": 3}
"""Frames of each set that is made for films."""

Act = Callable[[Any, dict[str, Any]], Any]
"""An action for an observation and the last info."""


def render_films(folder: Path) -> None:
    """Render the films that are not there yet."""
    gym.register_envs(avsec_gym)
    for entry in CATALOGUE:
        name = entry.id.partition("/")[2]
        if (folder / f"{name}{FACTS}").is_file():
            continue
        sys.stderr.write(f"film of {entry.id}\n")
        pictures, rate, caption = _episode(entry.id, folder)
        _write(folder, name, pictures, rate)
        (folder / f"{name}{FACTS}").write_text(caption + "\n", encoding="utf-8")  # The last file.


def _episode(id: str, folder: Path) -> tuple[list[np.ndarray], float, str]:
    """The pictures, pictures a second, and what is seen: the first success, else the last try."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # Of versions that stay.
        env = gym.make(id, render_mode="rgb_array", **_scenes(id, folder))
    act, who = _player(id, env)
    for seed in range(TRIES):
        env.action_space.seed(seed)
        observation, info = env.reset(seed=seed)
        pictures, over = [env.render()], False
        while not over:
            observation, _, terminated, truncated, info = env.step(act(observation, info))
            pictures.append(env.render())
            over = terminated or truncated
        if info["is_success"]:
            break
    rate = float(env.metadata.get("render_fps", 10))
    env.close()
    steps = len(pictures) - 1
    caption = f"Seed {seed}: {who}, {steps} step{'s' * (steps > 1)}. Outcome: {info['outcome']}. "
    if not info["is_success"]:
        return pictures, rate, caption + f"The agent does not succeed, with seeds 0 to {seed}."
    before = f"; with seeds 0 to {seed - 1} it did not" if seed else ""
    return pictures, rate, f"{caption}The agent succeeds{before}."


def _scenes(id: str, folder: Path) -> dict[str, Any]:
    """Arguments that make an environment play in few scenes."""
    if "Connected" in id:
        return {"scenarios": _set("connected", folder)}
    if "SensorIdentification" in id:
        return {"scenarios": _set("raw", folder)}
    if any(part in id for part in ("Detector", "Perturbation", "Patch", "Facula", "Lidar")):
        return {"scenarios": _set("mixed", folder)}
    return {}


def _set(suite: str, folder: Path) -> str:
    """A small set of the procedural world, made once."""
    place = folder / "sets" / suite
    make_data_set(suite_recipe(suite, FRAMES[suite], seed=0), place, workers=1)
    return str(place)


def _player(id: str, env: gym.Env[Any, Any]) -> tuple[Act, str]:
    """Who acts, and in words."""
    if id == "avsec/GhostObject-v1":
        agent = load_agent("ghost_place")
        return lambda seen, _: agent.predict(seen)[0], "the shipped agent acts"
    if id == "avsec/ClosedLoop-v0":
        driver = PlannerDriver(env)
        return lambda seen, _: driver.predict(seen)[0], "the planner drives"
    if id == "avsec/DetectorBenchmark-v0":
        detector = DetectorPolicy("stereo_rcnn", env)
        return lambda seen, _: detector.predict(seen)[0], "the agent is Stereo R-CNN"
    if id == "avsec/ConnectedValidation-v0":
        count = int(env.action_space.shape[0])  # type: ignore[index]
        return (
            lambda _, info: np.isin(np.arange(count), [int(i) for i in info["station"].split()]),
            "the base station's own rule decides",
        )
    return lambda _, __: env.action_space.sample(), "actions are drawn at random"


def _write(folder: Path, name: str, pictures: list[np.ndarray], rate: float) -> None:
    """Write the film and its last picture."""
    images = [Image.fromarray(picture) for picture in pictures]
    size = (WIDTH, round(WIDTH * images[0].height / images[0].width))
    small = [image.resize(size, Image.Resampling.LANCZOS) for image in images]
    folder.mkdir(parents=True, exist_ok=True)
    times = [round(1000 / rate)] * (len(small) - 1) + [2000]
    small[0].save(
        folder / f"{name}{FILM}", save_all=True, append_images=small[1:], duration=times, loop=0
    )
    small[-1].save(folder / f"{name}{STILL}")
