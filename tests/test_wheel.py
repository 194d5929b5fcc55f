"""The wheel by itself, outside of the clone that it was built from."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
BUILT = ("avsec_gym", "pyproject.toml", "setup.py", "README.md", "LICENSE", "MANIFEST.in")
EVERY_ID = """
import json
import gymnasium as gym
import avsec_gym
ids = sorted(id for id in gym.registry if id.startswith("avsec/"))
for id in ids:
    gym.make(id).close()
print(json.dumps([avsec_gym.__file__, ids]))
"""


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The environment of processes that find the wheel's package, and no clone."""
    folder = tmp_path_factory.mktemp("wheel")
    for name in BUILT:
        if (ROOT / name).is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / name, folder / "clone" / name, ignore=ignored)
        elif (ROOT / name).is_file():
            (folder / "clone").mkdir(exist_ok=True)
            shutil.copy(ROOT / name, folder / "clone" / name)
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check"]
    quietly = {"check": True, "capture_output": True, "cwd": folder}
    # The archive of sources first, and the wheel from nothing else: so both are whole.
    packed = "from setuptools.build_meta import build_sdist; build_sdist('../packed')"
    in_clone = quietly | {"cwd": folder / "clone"}
    subprocess.run([sys.executable, "-c", packed], **in_clone)  # type: ignore[call-overload]
    [sources] = (folder / "packed").glob("*.tar.gz")
    wheel = ["wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", "built", str(sources)]
    subprocess.run([*pip, *wheel], **quietly)  # type: ignore[call-overload]
    [built] = (folder / "built").glob("*.whl")
    install = ["install", "--no-deps", "--no-compile", "--target", "site", str(built)]
    subprocess.run([*pip, *install], **quietly)  # type: ignore[call-overload]
    shutil.rmtree(folder / "clone")
    (folder / "home").mkdir()
    return {
        **os.environ,
        "HOME": str(folder / "home"),
        "XDG_CACHE_HOME": str(folder / "home/cache"),
        "PYTHONPATH": str(folder / "site"),
        "PWD": str(folder / "home"),
    }


def said(environment: dict[str, str], *words: str) -> str:
    done = subprocess.run(
        [sys.executable, *words], env=environment, cwd=environment["HOME"], capture_output=True
    )
    assert done.returncode == 0, done.stderr.decode()[-2000:]
    return done.stdout.decode()


@pytest.mark.slow
def test_it_makes_every_environment(alone: dict[str, str]) -> None:
    place, ids = json.loads(said(alone, "-c", EVERY_ID).splitlines()[-1])
    assert place.startswith(alone["PYTHONPATH"])
    assert len(ids) == 12


@pytest.mark.slow
def test_it_evaluates_and_drives(alone: dict[str, str]) -> None:
    result = json.loads(said(alone, "-m", "avsec_gym", "evaluate", "--limit", "20", "--json"))
    assert result["schema"].startswith("avsec.evaluate/")
    words = ("drive", "--limit", "1", "--duration", "1", "--pictures", "0", "--json")
    driven = json.loads(said(alone, "-m", "avsec_gym", *words))
    assert driven["schema"].startswith("avsec.drive/")
