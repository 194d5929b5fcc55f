"""The site in a browser: one page of each kind, in light and dark, wide and on a phone."""

from __future__ import annotations

import subprocess
import sys
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
PAGES = (
    "index", "start/newcomer", "envs/GhostObject-v1", "commands", "parts", "cards/dsgn_small",
    "cards/patch_dsgn", "cards/agent_ghost_place", "leaderboard", "api/avsec_gym.registry",
    "detectors", "reproduce_chapter4", "studies/README", "studies/results/chapter4",
)  # fmt: skip
LOOKS = (("light", 1280), ("dark", 390))
SPHINXS_OWN = {"definition-list"}
"""What axe-core finds wrong with the lists that Sphinx describes functions in."""
RULES = """
() => axe.run(document, {
  runOnly: {type: "tag", values: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]},
  preload: false,
  resultTypes: ["violations"],
}).then((found) => found.violations.map((one) => [one.id, one.nodes[0].html]))
"""
BROKEN = (
    "[...document.images].filter((one) => one.complete && !one.naturalWidth).map((one) => one.src)"
)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    for module in ("sphinx", "furo", "myst_parser"):
        pytest.importorskip(module, reason="pip install -e '.[docs]'")
    out = tmp_path_factory.mktemp("site")
    command = [sys.executable, str(ROOT / "docs/site"), "--out", str(out)]
    subprocess.run(command, check=True, capture_output=True)
    return out / "html"


def test_every_kind_of_page_is_read_without_fault(browser: Any, site: Path) -> None:
    axe = pytest.importorskip("axe_playwright_python", reason="axe-core is not installed")
    script = (resources.files(axe) / "axe.min.js").read_text()
    for scheme, width in LOOKS:
        context = browser.new_context(viewport={"width": width, "height": 800}, color_scheme=scheme)
        for page in PAGES:
            tab, said = context.new_page(), list[str]()
            tab.on("console", lambda message, said=said: said.append(message.text))
            tab.on("pageerror", lambda error, said=said: said.append(str(error)))
            tab.goto((site / f"{page}.html").as_uri())
            assert said == [], (page, scheme)
            assert tab.evaluate("document.documentElement.scrollWidth") <= width, page
            assert tab.evaluate(BROKEN) == [], page
            tab.evaluate(script)
            found = [one for one in tab.evaluate(RULES) if one[0] not in SPHINXS_OWN]
            assert found == [], (page, scheme)
            tab.close()
        context.close()
