"""The start pages as their readers follow them: an empty folder, an empty cache, and a clock."""

from __future__ import annotations

import os
import re
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
    "avsec agents",  # Minutes of training, which tests of agents have in short form.
)


def commands_of(page: Path) -> list[str]:
    """The commands of a page in their order: blocks without a language."""
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)
    plain = [block.replace("\\\n", " ") for language, block in blocks if not language]
    lines = [line for block in plain for line in block.splitlines()]
    return [line for line in lines if line and not any(word in line for word in NOT_HERE)]


def test_every_page_has_something_to_type() -> None:
    pages = sorted(PAGES.glob("*.md"))
    assert len(pages) == 5
    assert sum(bool(commands_of(page)) for page in pages) >= 4
    for page in pages:
        for command in commands_of(page):
            assert command.split()[0] in ("avsec", "python"), command


@pytest.mark.slow
@pytest.mark.parametrize("page", sorted(PAGES.glob("*.md")), ids=lambda page: page.stem)
def test_a_reader_has_a_first_result_in_ten_minutes(page: Path, tmp_path: Path) -> None:
    # A clone, as far as pages speak of its examples.
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    programs = Path(sys.executable).parent
    home = {"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    environment = {**os.environ, **home, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}
    begun = time.monotonic()
    for command in commands_of(page):
        left = TEN_MINUTES - (time.monotonic() - begun)
        done = subprocess.run(
            command, shell=True, cwd=tmp_path, env=environment, capture_output=True, timeout=left
        )
        assert done.returncode == 0, f"{command}\n{done.stderr.decode()[-2000:]}"
        assert done.stdout or done.stderr, f"{command} says nothing"
    # What a page promises as a file is there.
    for folder in re.findall(r"--out (\S+)", "\n".join(commands_of(page))):
        assert any((tmp_path / folder).iterdir()), folder
