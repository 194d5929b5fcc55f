"""Holds every link of the built site: the file is there, and the anchor in it."""

from __future__ import annotations

import os
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

_LEADING = {"a": "href", "link": "href", "img": "src", "script": "src", "source": "srcset"}


class Links(HTMLParser):
    """The anchors of a page, and where it leads."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = {"", "top"}
        self.targets: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note a tag."""
        values = dict(attrs)
        self.anchors |= {values[name] or "" for name in ("id", "name") if name in values}
        if (target := values.get(_LEADING.get(tag, ""))) is not None:
            self.targets.append(target)


def broken_links(html: Path) -> list[str]:
    """A line for each link within the site that leads nowhere; addresses elsewhere are left out."""
    pages = {page: Links(page.read_text(encoding="utf-8")) for page in html.rglob("*.html")}
    lines = []
    for page, links in sorted(pages.items()):
        for target in links.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            file = Path(os.path.normpath(page.parent / unquote(parts.path))) if parts.path else page
            if not file.is_file():
                lines.append(f"{page.relative_to(html)}: {target}: no such file")
            elif file in pages and unquote(parts.fragment) not in pages[file].anchors:
                lines.append(f"{page.relative_to(html)}: {target}: no such anchor")
    return lines
