"""The start pages as their readers follow them: an empty folder, an empty cache, and a clock."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = ROOT / "docs/start"
TEN_MINUTES = 600
NOT_HERE = (
    "pip install",  # The tests stand on what it installs.
    "avsec demo",  # `make demo` is tried by itself.
    "KITTI/object",  # Data that not every reader has.
)
SHORTER = {
    "avsec agents train": "--steps 4096",
    "avsec agents evaluate": "--episodes 40",
}
"""What makes minutes of training to seconds, by the command that it is appended to."""


def steps_of(page: Path) -> list[str]:
    """What a reader of a page types, in its order: commands, and Python as a command."""
    steps = []
    for language, block in re.findall(
        r"^```(\w*)\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL
    ):
        if language == "python":
            steps.append(f"python -c {shlex.quote(block)}")
        elif not language:
            lines = [line.partition("#")[0] for line in block.replace("\\\n", " ").splitlines()]
            steps += [line.strip() for line in lines if line.strip()]
    return [step for step in steps if not any(word in step for word in NOT_HERE)]


def test_every_page_has_something_to_type() -> None:
    pages = sorted(PAGES.glob("*.md"))
    assert len(pages) == 5
    for page in pages:
        assert steps_of(page), page
        for step in steps_of(page):
            assert step.split()[0] in ("avsec", "python"), step


@pytest.mark.slow
@pytest.mark.parametrize("page", sorted(PAGES.glob("*.md")), ids=lambda page: page.stem)
def test_a_reader_has_a_first_result_in_ten_minutes(page: Path, tmp_path: Path) -> None:
    # A clone, as far as pages speak of its examples.
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    programs = Path(sys.executable).parent
    home = {"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    environment = {**os.environ, **home, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}
    begun = time.monotonic()
    for step in steps_of(page):
        command = " ".join([step, *(more for of, more in SHORTER.items() if step.startswith(of))])
        left = TEN_MINUTES - (time.monotonic() - begun)
        done = subprocess.run(
            command, shell=True, cwd=tmp_path, env=environment, capture_output=True, timeout=left
        )
        assert done.returncode == 0, f"{command}\n{done.stderr.decode()[-2000:]}"
        assert done.stdout or done.stderr, f"{command} says nothing"
    # What a page promises as a file is there.
    for folder in re.findall(r"--out (\S+)", "\n".join(steps_of(page))):
        assert any((tmp_path / folder).iterdir()), folder
