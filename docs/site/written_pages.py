"""The pages that people wrote, brought to the site: Markdown that a code host shows as well.

A page keeps its text.  Its links are turned: to another page of the site, to a picture or a report
beside it, or to the code host, where the site has no such file.  What its code needs beside an
installation stands above the first of it.
"""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

from contents import CONTENTS, toctree
from repository import ROOT, address

_LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)\s]*)?\)")
_NEEDS = tomllib.loads(Path(__file__).with_name("snippet_needs.toml").read_text("utf-8"))
_FENCED = re.compile(r"(^```.*?^```$)", re.MULTILINE | re.DOTALL)


def pages() -> dict[Path, str]:
    """Each page of the repository that is shown, and its place on the site."""
    result = {ROOT / f"{name}.md": f"{name}.md" for name in ("CHANGELOG", "CONTRIBUTING")}
    for page in sorted((ROOT / "docs").rglob("*.md")):
        result[page] = page.relative_to(ROOT / "docs").as_posix()
    for page in (ROOT / "studies/README.md", *sorted((ROOT / "studies/results").glob("*.md"))):
        result[page] = page.relative_to(ROOT).as_posix()
    return result


def write_pages(source: Path) -> set[Path]:
    """Write them, the pictures they show and the reports they link; returns the files."""
    shown = pages()
    written: set[Path] = set()
    for page, place in shown.items():
        text, files = _turned(page, place, shown)
        if needs := _NEEDS.get(place.removesuffix(".md")):
            text = text.replace(
                "```python", f"*The code of this page needs {needs}.*\n\n```python", 1
            )
        if place == "index.md":
            text += "".join("\n" + toctree(under, name) for name, under in CONTENTS.items())
        if place == "studies/README.md":
            results = [to for to in shown.values() if to.startswith("studies/results/")]
            text += "\n" + toctree(f"results/{Path(to).stem}" for to in results)
        written.add(write_changed(source / place, text.encode()))
        for file in files:
            written.add(write_changed(source / _place(file), file.read_bytes()))
    return written


def write_changed(file: Path, content: bytes) -> Path:
    """Write a file, unless it is the same already: Sphinx reads again what is newer."""
    if not file.is_file() or file.read_bytes() != content:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    return file


def _turned(page: Path, place: str, shown: dict[Path, str]) -> tuple[str, set[Path]]:
    """The text with links for the site, and the pictures and reports that it needs."""
    files: set[Path] = set()
    here = Path(place).parent

    def turned(match: re.Match[str]) -> str:
        mark, words, link, anchor = match[1], match[2], match[3], match[4] or ""
        target = Path(os.path.normpath(page.parent / link))
        if re.match(r"[a-z]+:", link) or not target.exists():
            return match[0]
        if target in shown:
            to = os.path.relpath(shown[target], here)
        elif mark or target.suffix == ".html":
            files.add(target)
            to = os.path.relpath(_place(target), here)
            if not mark:  # A link in Markdown would download it.
                return f'<a href="{to}">{words}</a>'
        else:
            to = address(target)
        return f"{mark}[{words}]({to}{anchor})"

    # Between the blocks of code only: `results[0](frame)` is no link.
    parts = _FENCED.split(page.read_text(encoding="utf-8"))
    parts[::2] = [_LINK.sub(turned, part) for part in parts[::2]]
    return "".join(parts), files


def _place(file: Path) -> Path:
    """A file's place on the site: that in the repository, docs/ being the site's root."""
    place = file.relative_to(ROOT)
    return place.relative_to("docs") if place.parts[0] == "docs" else place
