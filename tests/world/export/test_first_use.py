"""The first use of an image environment, with an empty cache, from wherever users start."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from avsec_gym.storage.folder_lock import folder_lock

TIMEOUT = 300
"""Seconds after which a program counts as hanging."""
# Instead of rendering frames, workers copy some. No guard, as users write scripts.
QUICK = """
import sys
sys.path.insert(0, {folder!r})
import gymnasium as gym
import avsec_gym
from avsec_gym.world.export import default_suites
from copied_frames import CopiedFrames

default_suites.suite_recipe = lambda *_, **__: CopiedFrames({source!r})
"""
# Real ones, but small.
RENDERED = """
from functools import partial
import gymnasium as gym
import avsec_gym
from avsec_gym.rig import KITTI_CAMERAS, camera_rig
from avsec_gym.world.export import Sensors, default_suites, suite_recipe

size = {"size": (310, 94), "focal_length": 180.0, "centre": (152.0, 43.0)}
sensors = Sensors((2, 3), lidar=False, rig=camera_rig(KITTI_CAMERAS, **size))
default_suites.suite_recipe = partial(suite_recipe, sensors=sensors)
default_suites.DEFAULT_FRAMES["mixed"] = 2
"""
COPIED_FRAMES = '''
"""A data set whose frames are those of another."""

import shutil
from dataclasses import dataclass
from pathlib import Path
from time import sleep


@dataclass(frozen=True)
class CopiedFrames:
    source: str
    settings = {"copied": True}
    last_files = "training/label_2/*.txt"

    def __len__(self):
        return 2

    def last_file(self, number):
        return f"training/label_2/{number:06d}.txt"

    def make(self, root, number):
        sleep(0.5)  # So that others have to wait.
        last = Path(self.source, self.last_file(number))
        for path in sorted(Path(self.source).glob(f"training/*/{number:06d}*"), key=last.__eq__):
            copy = root / path.relative_to(self.source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, copy)
        return []

    def finish(self, root):
        name = "training/road_type.csv"
        shutil.copyfile(Path(self.source, name), root / name)
'''
ONE = """
env = gym.make("avsec/DetectorBenchmark-v0")
_, info = env.reset(seed=0)
print("scene", info["scenario"])
"""
ASYNC = """
envs = gym.make_vec("avsec/DetectorBenchmark-v0", num_envs=2, vectorization_mode="async")
_, info = envs.reset(seed=0)
print("scene", *info["scenario"])
envs.close()
"""
SUBPROC = """
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import SubprocVecEnv

forked = {"start_method": "fork"}
envs = make_vec_env(
    "avsec/DetectorBenchmark-v0", 3, vec_env_cls=SubprocVecEnv, vec_env_kwargs=forked
)

envs.seed(0)
_ = envs.reset()
print("scene", *[info["scenario"] for info in envs.reset_infos])
envs.close()
"""
# As SB3 asks for where processes are started anew, which is its default.
GUARDED = """
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import SubprocVecEnv

if __name__ == "__main__":
    started = {"start_method": "METHOD"}
    envs = make_vec_env(
        "avsec/DetectorBenchmark-v0", 3, vec_env_cls=SubprocVecEnv, vec_env_kwargs=started
    )
    envs.seed(0)
    envs.reset()
    print("scene", *[info["scenario"] for info in envs.reset_infos])
    envs.close()
"""
FORKSERVER, SPAWN = (GUARDED.replace("METHOD", method) for method in ("forkserver", "spawn"))


@pytest.fixture
def quick(mixed: Path, tmp_path: Path) -> str:
    (tmp_path / "copied_frames.py").write_text(COPIED_FRAMES)
    return QUICK.format(folder=str(tmp_path), source=str(mixed))


@pytest.fixture
def cache(tmp_path: Path) -> Path:
    """An empty one."""
    cache = tmp_path / "cache"
    cache.mkdir()
    return cache


def command(way: str, program: str, tmp_path: Path) -> list[str]:
    script = tmp_path / "script.py"
    script.write_text(program)
    words = {
        "script": [str(script)],
        "stdin": ["-"],
        "interactive": ["-i", "-q"],
    }
    return [sys.executable, *words[way]]


def run(way: str, program: str, cache: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command(way, program, cache.parent),
        input=program,
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        env=os.environ | {"AVSEC_CACHE": str(cache)},
    )


@pytest.mark.parametrize(
    ("way", "program", "scenes"),
    [
        ("script", ONE, 1),
        pytest.param("stdin", ONE, 1, marks=pytest.mark.slow),
        pytest.param("interactive", ONE, 1, marks=pytest.mark.slow),
        ("script", ASYNC, 2),
        pytest.param("script", SUBPROC, 3, marks=pytest.mark.slow),
        pytest.param("stdin", SUBPROC, 3, marks=pytest.mark.slow),
        pytest.param("script", FORKSERVER, 3, marks=pytest.mark.slow),
        pytest.param("script", SPAWN, 3, marks=pytest.mark.slow),
    ],
)
def test_the_suite_is_made_once(
    way: str, program: str, scenes: int, quick: str, cache: Path
) -> None:
    done = run(way, quick + program, cache)
    assert done.returncode == 0, done.stderr
    told = [line.split() for line in done.stdout.splitlines() if line.startswith("scene")]
    assert [len(words) - 1 for words in told] == [scenes], done.stderr
    assert set(told[0][1:]) <= {"000000", "000001"}
    assert done.stderr.count("making the default suite mixed, once: ") == 1
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_so_it_is_with_frames_that_are_rendered(cache: Path) -> None:
    """And textures that are drawn, by both workers, whoever comes first."""
    done = run("stdin", RENDERED + ONE, cache)
    assert done.returncode == 0, done.stderr
    assert "scene 00000" in done.stdout
    assert done.stderr.count("making the default suite mixed, once: 2 frames") == 1


def test_who_waits_says_for_what(quick: str, cache: Path, tmp_path: Path) -> None:
    suites = cache / "suites"
    suites.mkdir()
    with folder_lock(suites):
        process = subprocess.Popen(
            command("script", quick + ONE, tmp_path),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"AVSEC_CACHE": str(cache)},
        )
        try:
            assert process.stderr is not None
            first = process.stderr.readline()
        except BaseException:
            process.kill()
            raise
    said = f"waiting for the default suite mixed: another process is at work in {suites}"
    assert first.strip() == said
    output, errors = process.communicate(timeout=TIMEOUT)
    assert "scene" in output
    assert "making the default suite mixed" in errors


def test_a_forked_process_does_not_keep_the_lock(tmp_path: Path) -> None:
    """Neither when its parent lets go of it, nor when that is killed."""
    program = (
        "import os, sys, time; from pathlib import Path;"
        "from avsec_gym.storage.folder_lock import folder_lock\n"
        "with folder_lock(Path(sys.argv[1])):\n"
        "    if os.fork() == 0:\n"
        "        os.write(1, b'forked\\n')\n"
        "        sys.stdin.read()\n"
        "        os._exit(0)\n"
        "    if sys.argv[2] == 'killed': time.sleep(60)\n"
        "os.write(1, b'let go\\n')\n"
        "time.sleep(60)\n"
    )
    for how in ("killed", "let go"):
        with subprocess.Popen(
            [sys.executable, "-c", program, str(tmp_path), how],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        ) as process:
            try:
                assert process.stdout is not None
                said = {process.stdout.readline().strip()}
                if how == "let go":
                    said.add(process.stdout.readline().strip())
                assert said == ({"forked"} if how == "killed" else {"forked", "let go"})
                if how == "killed":
                    process.kill()
                    process.wait()
                with folder_lock(tmp_path):  # Refused if the other one had it.
                    pass
            finally:
                process.kill()
