"""What pyproject.toml cannot say: the README as a package index needs it.

An index shows the README alone, so that its links to pages and pictures of the repository have to
be whole addresses there: those of the release's tag, which never change; a tree on its way to the
next release has no tag yet, and leads to the branch.
"""

import re
import tomllib
from pathlib import Path

from setuptools import setup

ROOT = Path(__file__).parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
REPOSITORY = PROJECT["urls"]["Repository"]
PICTURES = REPOSITORY.replace("https://github.com", "https://raw.githubusercontent.com")


def absolute_links(text: str, tag: str) -> str:
    """Markdown whose links to files are whole addresses of a tag of the repository."""

    def address(match: re.Match[str]) -> str:
        mark, words, target = match.groups()
        if re.match(r"[a-z]+:|#", target):
            return match[0]
        base = f"{PICTURES}/{tag}" if mark else f"{REPOSITORY}/blob/{tag}"
        return f"{mark}[{words}]({base}/{target})"

    return re.sub(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)", address, text)


def tag_of(version: str) -> str:
    """The tag of a release; of what is no release, the branch."""
    return "main" if ".dev" in version else f"v{version}"


if __name__ == "__main__":
    setup(
        long_description=absolute_links(
            (ROOT / "README.md").read_text(encoding="utf-8"), tag_of(PROJECT["version"])
        ),
        long_description_content_type="text/markdown",
    )
