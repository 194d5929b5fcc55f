"""The demo as a newcomer meets it: a shell, an empty folder, an empty cache, nothing replaced."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from avsec_gym.experiments.demo.telling_drive import TELLING


@pytest.mark.slow
def test_it_tells_its_story_from_nothing(tmp_path: Path) -> None:
    """Frames are rendered, networks look at them and are attacked, and a car drives on."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")}
    page = tmp_path / "runs/demo/report.html"
    command = [sys.executable, "-m", "avsec_gym", "demo", "--scenarios", "1"]
    began = time.monotonic()
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as demo:
        while demo.poll() is None and not page.exists():
            assert time.monotonic() - began < 1200.0
            time.sleep(0.2)
        assert demo.poll() is None, "the first page comes while it goes on"
        told = (demo.communicate()[0] or b"").decode()
    assert demo.returncode == 0, told[-2000:]
    shown = page.read_text()
    # The scene that was chosen is still one in which the light decides.
    assert f"Scene {TELLING[0].scene}, the first in which" in shown
    assert "and the light decides" in shown
    assert "Unattacked: it reaches its goal" in shown
    assert "With a laser on the left camera: it collides and is to blame" in shown
    assert "its first emergency stop begins" in shown
