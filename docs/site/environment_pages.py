"""A page for each registered environment: its docstring, its spaces, its arguments, a film."""

from __future__ import annotations

import inspect
import re
import tempfile
import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from contents import toctree
from episode_films import FACTS, FILM, STILL
from repository import address
from written_pages import write_changed

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti import write_object_frame
from avsec_gym.registration import CATALOGUE, EnvironmentEntry
from avsec_gym.rig import KITTI_CAMERAS, KITTI_CENTRE, KITTI_FOCAL_LENGTH, KITTI_SIZE, camera_rig

ROOT = Path(__file__).parents[2]
_NEEDS_A_FRAME = "avsec/DetectorBenchmark-v0"
"""Its spaces are known from a frame's size."""


def write_pages(source: Path, films: Path) -> set[Path]:
    """Write a page for each, and their list; returns the files."""
    written = {
        write_changed(source / f"envs/{file_name(entry.id)}.md", page(entry, films).encode())
        for entry in CATALOGUE
    }
    index = "# Environments by id\n\n| id | |\n|---|---|\n"
    for entry in CATALOGUE:
        summary = inspect.getdoc(_class(entry)) or ""
        link = f"[`{entry.id}`]({file_name(entry.id)}.md)"
        index += f"| {link} | {summary.splitlines()[0]} |\n"
    index += "\nHow they belong together: [Environments](../environments.md).\n\n"
    index += toctree(file_name(entry.id) for entry in CATALOGUE)
    return written | {write_changed(source / "envs/index.md", index.encode())}


def file_name(id: str) -> str:
    """A page's name: ``GhostObject-v1``."""
    return id.partition("/")[2]


def page(entry: EnvironmentEntry, films: Path) -> str:
    """The page of one environment, in Markdown."""
    environment = _class(entry)
    first, _, rest = (inspect.getdoc(environment) or "").partition("\n")
    code = Path(inspect.getfile(environment))
    parts = [
        f"# {entry.id}\n\n{first}\n",
        _film(entry, films),
        f'```python\nimport gymnasium as gym\n\nenv = gym.make("avsec_gym:{entry.id}")\n```\n',
        _specification(entry, code),
        _linked(rest.strip()) + "\n",
        f"## Defaults\n\n{_defaults(environment)}",
    ]
    return "\n".join(part for part in parts if part)


def _class(entry: EnvironmentEntry) -> type[gym.Env[Any, Any]]:
    module, name = entry.entry_point.split(":")
    return getattr(import_module(module), name)


def _film(entry: EnvironmentEntry, films: Path) -> str:
    """The moving picture, still for readers who want no motion; empty where there is none."""
    name = file_name(entry.id)
    if not (films / f"{name}{FACTS}").is_file():  # The last file of a film.
        return ""
    caption = (films / f"{name}{FACTS}").read_text(encoding="utf-8").strip()
    return (
        f'<picture class="film"><source media="(prefers-reduced-motion: reduce)" '
        f'srcset="../films/{name}{STILL}"><img src="../films/{name}{FILM}" '
        f'alt="An episode of {entry.id}: {caption}"></picture>\n\n*{caption}*\n'
    )


def _specification(entry: EnvironmentEntry, code: Path) -> str:
    """Spaces, longest episode, vector form, source."""
    observation, action = spaces(entry)
    steps = entry.max_episode_steps
    rows = {
        "observation space": _of_space(observation),
        "action space": _of_space(action),
        "`max_episode_steps`": "none: it ends by itself" if steps is None else str(steps),
        "`gym.make_vec`": "batched, in one process"
        if entry.vector_entry_point
        else "Gymnasium's own, of single environments",
        "source": f"[{code.relative_to(ROOT)}]({address(code)})",
    }
    return "| | |\n|---|---|\n" + "".join(f"| {name} | {what} |\n" for name, what in rows.items())


def spaces(entry: EnvironmentEntry) -> tuple[gym.Space[Any], gym.Space[Any]]:
    """The observation and the action space with the default arguments; nothing is rendered."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # Of versions that stay.
        given = {}
        if entry.id == _NEEDS_A_FRAME:
            _write_dark_frame(Path(folder) / "training")
            given["scenarios"] = folder
        env = gym.make(entry.id, **given)
        return env.observation_space, env.action_space


def _write_dark_frame(folder: Path) -> None:
    """A frame of the size that the default suite has."""
    dark = np.zeros((KITTI_SIZE[1], KITTI_SIZE[0], 3), np.uint8)
    rig = camera_rig(
        KITTI_CAMERAS, focal_length=KITTI_FOCAL_LENGTH, centre=KITTI_CENTRE, size=KITTI_SIZE
    )
    frame = SensorFrame("000000", rig.calibration, {2: dark, 3: dark})
    write_object_frame(folder, frame, Boxes3D.empty())


def _of_space(space: gym.Space[Any]) -> str:
    if isinstance(space, gym.spaces.Dict):
        return "<br>".join(f"`{name}`: `{each}`" for name, each in space.items())
    return f"`{space}`"


def _defaults(environment: type[gym.Env[Any, Any]]) -> str:
    """A table of what `gym.make` takes, from the signature."""
    known = list(inspect.signature(environment).parameters.values())
    lines = [
        f"| `{each.name}` | `{each.default!r}` |"
        for each in known
        if each.kind == each.KEYWORD_ONLY
    ]
    return "\n".join(["| argument | default |", "|---|---|", *lines, ""])


def _linked(text: str) -> str:
    """A docstring whose names of pages, environments and code are links."""
    text = re.sub(r"docs/(\w+\.md)", r"[docs/\1](../\1)", text)
    for entry in CATALOGUE:
        text = text.replace(f"`{entry.id}`", f"[`{entry.id}`]({file_name(entry.id)}.md)")
    return re.sub(r"(?<!`)`(avsec_gym(?:\.\w+)+)`(?!`)", r"{py:obj}`\1`", text)
