"""What stands at the root agrees with the rest: links, versions, the picture of the floors."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.version import Version
from setuptools import find_packages

import avsec_gym

ROOT = Path(__file__).parents[1]
PAGES = sorted(
    page
    for pattern in ("*.md", "docs/**/*.md", "studies/**/*.md", ".github/**/*.md")
    for page in ROOT.glob(pattern)
)
_RELEASE = r"^## (\S+) \((\S+)\)$"
"""The heading of a release in the changelog: version and date."""
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        if not link.startswith(("http", "#", "mailto:")):
            assert (page.parent / link.partition("#")[0]).exists(), link


def test_the_floors_are_drawn_as_the_linter_checks_them() -> None:
    command = [sys.executable, str(ROOT / "docs/floors.py"), "--check"]
    assert subprocess.run(command, check=False).returncode == 0, "run python docs/floors.py"


def test_version_and_date_agree() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    newest = re.search(_RELEASE, (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert newest is not None
    assert newest.groups() == (citation["version"], str(citation["date-released"]))


def test_the_tree_is_of_the_newest_release_or_on_its_way_to_the_next() -> None:
    """A tree with unreleased changes has a version of its own, above the newest release's."""
    text = (ROOT / "CHANGELOG.md").read_text()
    newest = re.search(_RELEASE, text, re.MULTILINE)
    assert newest is not None
    version = Version(PROJECT["project"]["version"])
    unreleased = re.search(r"^## Unreleased\n+(?=### )", text, re.MULTILINE) is not None
    assert version.is_devrelease == unreleased
    assert version > Version(newest[1]) if unreleased else version == Version(newest[1])
    assert str(version) == avsec_gym.__version__, "pip install -e . takes the new one over"


def test_the_wheel_holds_the_package_alone() -> None:
    wanted = PROJECT["tool"]["setuptools"]["packages"]["find"]["include"]
    found = find_packages(str(ROOT), include=wanted)
    assert "avsec_gym.storage" in found
    assert {name.partition(".")[0] for name in found} == {"avsec_gym"}


def test_the_wheel_holds_every_file_beside_the_code() -> None:
    patterns = PROJECT["tool"]["setuptools"]["package-data"]["avsec_gym"]
    package = ROOT / "avsec_gym"
    held = {path for pattern in patterns for path in package.glob(pattern)}
    left_out = [
        path
        for path in package.rglob("*")
        if path.is_file() and path.suffix != ".py" and "__pycache__" not in path.parts
    ]
    assert set(left_out) <= held, "name it in pyproject.toml, package-data"


def test_an_index_shows_a_readme_whose_links_lead_to_the_release() -> None:
    spec = importlib.util.spec_from_file_location("setup", ROOT / "setup.py")
    assert spec is not None
    assert spec.loader is not None
    setup = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(setup)
    assert setup.tag_of("0.2.0.dev0") == "main"
    text = setup.absolute_links((ROOT / "README.md").read_text(), setup.tag_of("9.9.9"))
    links = re.findall(r"(!?)\[[^\]]*\]\(([^)\s]+)\)", text)
    own = 0
    for mark, link in links:
        assert re.match(r"https://|#", link), link
        for base in (f"{setup.REPOSITORY}/blob/v9.9.9/", f"{setup.PICTURES}/v9.9.9/"):
            if link.startswith(base):
                assert (base.startswith(setup.PICTURES)) == bool(mark)
                assert (ROOT / link.removeprefix(base).partition("#")[0]).exists(), link
                own += 1
    assert own > 20
    assert (ROOT / "README.md").read_text().count("](") == text.count("](")


@pytest.mark.parametrize("name", ["envs", "attacks", "planners"])
def test_the_links_at_the_root_are_not_imported(name: str) -> None:
    assert (ROOT / name).resolve() == ROOT / "avsec_gym" / name
    command = [sys.executable, "-c", f"import {name}"]
    done = subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)
    assert done.returncode == 1
    assert f"import avsec_gym.{name}" in done.stderr


def test_the_image_copies_what_is_there() -> None:
    copied = re.findall(r"^COPY (.+) \S+$", (ROOT / "Dockerfile").read_text(), re.MULTILINE)
    names = " ".join(copied).split()
    assert all((ROOT / name).exists() for name in names)
    # What a wheel is made of, the licence files that its metadata name among it.
    assert {"pyproject.toml", "setup.py", "README.md", "LICENSE", "avsec_gym"} <= set(names)


def test_the_workflow_runs_what_runs_here() -> None:
    workflow = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text())
    steps = [step.get("run") for job in workflow["jobs"].values() for step in job["steps"]]
    assert ".ci/run" in steps
    assert (ROOT / ".ci/run").stat().st_mode & 0o100
    for form in (ROOT / ".github/ISSUE_TEMPLATE").glob("[!c]*.yml"):
        content = yaml.safe_load(form.read_text())
        assert {"name", "description", "body"} <= content.keys(), form
