"""Builds the documentation site, warnings as errors: `python docs/site`, or `make docs-site`.

    python docs/site             # out/site/html/index.html
    python docs/site --films     # with a film of an episode of each environment, rendered once

What is generated lies in out/, which git ignores.  Films stay in out/site/films, and are shown
without --films, too; to render one anew, remove its files.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # An environment may hold another checkout's.

import api_pages
import command_pages
import entry_board
import environment_pages
import episode_films
import model_cards
import part_pages
import written_pages
from link_check import broken_links
from repository import ROOT
from sphinx.cmd.build import build_main


def main() -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--films", action="store_true", help="render films that are not there yet")
    parser.add_argument("--out", type=Path, default=ROOT / "out/site", help="folder of the site")
    given = parser.parse_args()
    out: Path = given.out.resolve()
    films = out / "films"
    if given.films:
        episode_films.render_films(films)
    build_site(out, films)
    lines = broken_links(out / "html")
    for line in lines:
        sys.stderr.write(line + "\n")
    if not lines:
        sys.stdout.write(f"{out / 'html/index.html'}\n")
    return bool(lines)


def build_site(out: Path, films: Path) -> None:
    """Write all pages into `source`, and their HTML into `html`, of a folder.

    Raises:
        SystemExit: Sphinx warns of something.
    """
    source = out / "source"
    written = {
        *written_pages.write_pages(source),
        *environment_pages.write_pages(source, films),
        *part_pages.write_pages(source),
        *command_pages.write_pages(source),
        *model_cards.write_pages(source),
        *entry_board.write_pages(source),
        *api_pages.write_pages(source),
    }
    for file in source.rglob("*"):  # Of an earlier build.
        if file.is_file() and file not in written:
            file.unlink()
    shutil.rmtree(out / "html/films", ignore_errors=True)
    settings = ["-c", str(Path(__file__).parent), "-d", str(out / "doctrees")]
    code = build_main(
        ["-q", "-W", "--keep-going", "-b", "html", *settings, str(source), str(out / "html")]
    )
    if code:
        raise SystemExit(code)
    for report in source.rglob("*.html"):
        shutil.copy(report, out / "html" / report.relative_to(source))
    if films.is_dir():
        shutil.copytree(films, out / "html/films", ignore=shutil.ignore_patterns("sets"))


if __name__ == "__main__":
    sys.exit(main())
