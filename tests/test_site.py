"""The documentation: its site is built, its links lead somewhere, its snippets are true."""

from __future__ import annotations

import ast
import importlib
import json
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Callable
from importlib import resources
from inspect import signature
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from avsec_gym.cli import COMMANDS, CommandGroup, every_command
from avsec_gym.commands.arguments import parse
from avsec_gym.registration import CATALOGUE

ROOT = Path(__file__).parents[1]
SITE = ROOT / "docs/site"
FILMED = ("avsec/GhostObject-v1", "avsec/ClosedLoop-v0", "avsec/ClosedLoopAttack-v0")
"""Whose scenes are not rendered."""
EVERY = every_command()
ONE_OF_EACH = (
    "index", "start/newcomer", "envs/GhostObject-v1", "commands", "parts", "cards/dsgn_small",
    "cards/patch_dsgn", "cards/agent_ghost_place", "leaderboard", "api/avsec_gym.registry",
    "detectors", "reproduce_chapter4", "studies/README", "studies/results/chapter4",
)  # fmt: skip
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
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
RUN_HERE = ("agents", "from_safebench", "layouts", "start/rl_researcher", "world_made")
"""Pages whose snippets run below, as they stand."""
RUN_SLOWLY = ("agents", "from_safebench", "start/rl_researcher", "world_made")
RUN_ELSEWHERE = {
    "README": "tests/test_examples.py",
    "environments": "tests/envs/test_whole.py, tests/envs/test_record_video.py",
    "extending": "tests/plugins/test_plugin_files.py",
    "from_highway_env": "tests/test_examples.py",
}
NEED = tomllib.loads((ROOT / "docs/site/snippet_needs.toml").read_text())
"""Pages whose snippets ask for more than a test has; their names are held below all the same."""


def blocks(page: Path, language: str) -> list[str]:
    """The blocks of code of a page in a language; commands stand in blocks without one."""
    pattern = rf"^```{language}\n(.*?)^```$"
    return re.findall(pattern, page.read_text(), re.MULTILINE | re.DOTALL)


def test_the_site_shows_what_a_snippet_needs(tmp_path: Path) -> None:
    script = (
        "import sys; from pathlib import Path; sys.path.insert(0, 'docs/site');"
        " from written_pages import write_pages; write_pages(Path(sys.argv[1]))"
    )
    subprocess.run([sys.executable, "-c", script, str(tmp_path)], cwd=ROOT, check=True)
    for name, needs in NEED.items():
        before = (tmp_path / f"{name}.md").read_text().partition("```python")[0]
        assert before.endswith(f"*The code of this page needs {needs}.*\n\n"), name
    assert "The code of this page" not in (tmp_path / "agents.md").read_text()


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix().removeprefix("docs/").removesuffix(".md")


def test_every_page_with_a_snippet_is_accounted_for() -> None:
    with_snippets = {name_of(page) for page in PAGES if blocks(page, "python")}
    assert with_snippets == {*RUN_HERE, *RUN_ELSEWHERE, *NEED}
    for tests in RUN_ELSEWHERE.values():
        assert all((ROOT / test).is_file() for test in tests.split(", "))


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow if name in RUN_SLOWLY else []) for name in RUN_HERE],
)
def test_snippets_run_as_they_stand(name: str, tmp_path: Path) -> None:
    code = "\n".join(blocks(ROOT / f"docs/{name}.md", "python"))
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, cwd=tmp_path)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_snippets_name_what_there_is(page: Path) -> None:
    """Each import of ours, each environment and its arguments, where nothing runs them, too."""
    environments = {entry.id: entry for entry in CATALOGUE}
    for block in blocks(page, "python"):
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("avsec_gym"):
                try:
                    module = importlib.import_module(node.module or "")
                except ModuleNotFoundError as error:
                    if (error.name or "").startswith("avsec_gym"):
                        raise
                    continue  # An extra's is missing.
                for alias in node.names:
                    assert hasattr(module, alias.name), f"{node.module}.{alias.name}"
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "gym.make":
                id = ast.literal_eval(node.args[0]).removeprefix("avsec_gym:")
                if id.startswith("avsec/"):
                    module_name, _, kind = environments[id].entry_point.partition(":")
                    known = signature(getattr(importlib.import_module(module_name), kind))
                    given = {word.arg for word in node.keywords if word.arg}
                    assert given <= {*known.parameters, "max_episode_steps"}, id


def command_of(words: list[str]) -> tuple[Any, list[str]]:
    """The class of a command, and the words after its name."""
    there: object = COMMANDS[words[0]]
    rest = words[1:]
    while isinstance(there, CommandGroup):
        there, rest = there.commands[rest[0]], rest[1:]
    module, _, kind = str(there).partition(":")
    return getattr(importlib.import_module(module), kind), rest


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_commands_are_understood(page: Path) -> None:
    """Nothing is run: commands, options and values of a block are those that there are."""
    for block in blocks(page, "(?:sh)?"):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True) if line.startswith("avsec ") else []
            if not words or {"--help", "...", "|"} & set(words):
                continue
            command, rest = command_of(words[1:])
            try:
                parse(command, rest, "avsec")
            except SystemExit:
                pytest.fail(line)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_commands_in_sentences_have_their_options(
    page: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They are shortened: what is required may be left out."""
    for line in re.findall(r"`(avsec [^`\n]+ --[^`\n]+)`", page.read_text()):
        words = line.replace("|", " ").split()[1:]
        if words[0] not in COMMANDS:
            continue  # A place for one: COMMAND.
        command, _ = command_of(words)
        with pytest.raises(SystemExit):
            parse(command, ["--help"], "avsec")
        known = set(re.findall(r"--[a-z-]+", capsys.readouterr().out))
        given = {word.partition("=")[0] for word in words if word.startswith("--")}
        assert given - {"--help"} <= known, line


@pytest.fixture
def site(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Any]:
    """The modules that make the site, by their names."""
    monkeypatch.syspath_prepend(str(SITE))
    return importlib.import_module


def test_links_of_pages_lead_to_pages_or_to_the_code_host(
    site: Callable[[str], Any], tmp_path: Path
) -> None:
    site("written_pages").write_pages(tmp_path)
    page = (tmp_path / "install.md").read_text()
    assert "[Dockerfile](https://github.com/avsec-gym/avsec-gym/blob/main/Dockerfile)" in page
    page = (tmp_path / "chapter5.md").read_text()
    assert "](studies/results/chapter5.md)" in page
    assert "](images/chapter5.png)" in page
    assert (tmp_path / "images/chapter5.png").is_file()
    # Code is no link, whatever its brackets look like.
    assert blocks(tmp_path / "attacks.md", "python") == blocks(ROOT / "docs/attacks.md", "python")
    # A code host shows the page as it stands; the sidebar is the site's own.
    assert "{toctree}" in (tmp_path / "index.md").read_text()
    assert "{toctree}" not in (ROOT / "docs/index.md").read_text()


def test_a_page_of_an_environment_shows_what_it_is(
    site: Callable[[str], Any], tmp_path: Path
) -> None:
    page_of, entry = site("environment_pages").page, CATALOGUE[1]
    page = page_of(entry, tmp_path)
    assert "`Box(-1.0, 1.0, (381,), float32)`" in page
    assert "| `price` | `0.02` |" in page
    assert "## Reward" in page
    assert "<picture" not in page
    for end in (".webp", "_still.webp"):
        (tmp_path / f"GhostObject-v1{end}").touch()
    (tmp_path / "GhostObject-v1.txt").write_text("Seed 0: what was seen.\n")
    page = page_of(entry, tmp_path)
    assert 'src="../films/GhostObject-v1.webp"' in page
    assert "*Seed 0: what was seen.*" in page


@pytest.mark.slow
def test_films_are_of_whole_episodes_and_stand_on_the_pages(
    site: Callable[[str], Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    films = site("episode_films")
    shown = [each for each in CATALOGUE if each.id in FILMED]
    monkeypatch.setattr(films, "CATALOGUE", shown)
    films.render_films(tmp_path)
    for entry in shown:
        name = entry.id.partition("/")[2]
        caption = (tmp_path / f"{name}.txt").read_text()
        with Image.open(tmp_path / f"{name}.webp") as film:
            assert f" {film.n_frames - 1} step" in caption  # type: ignore[attr-defined]
            assert len(film.getcolors(film.width * film.height) or range(256)) > 50  # No blank.
        assert f"../films/{name}.webp" in site("environment_pages").page(entry, tmp_path)
    monkeypatch.setattr(films, "_episode", lambda *_: pytest.fail("it is there"))
    films.render_films(tmp_path)


def test_the_check_of_links_finds_what_is_broken(
    site: Callable[[str], Any], tmp_path: Path
) -> None:
    broken_links = site("link_check").broken_links
    (tmp_path / "a.html").write_text('<h1 id="here"></h1><a href="b.html#there">b</a>')
    (tmp_path / "b.html").write_text('<a href="a.html#here"></a><a href="https://example.org/x">')
    assert broken_links(tmp_path) == ["a.html: b.html#there: no such anchor"]
    (tmp_path / "b.html").write_text('<a id="there" href="c.html"></a><img src="missing.png">')
    assert broken_links(tmp_path) == [
        "b.html: c.html: no such file", "b.html: missing.png: no such file",
    ]  # fmt: skip


def test_the_board_is_a_page_with_every_entry(site: Callable[[str], Any], tmp_path: Path) -> None:
    [page] = site("entry_board").write_pages(tmp_path)
    text = page.read_text()
    assert "leaderboard" in site("contents").CONTENTS["Results"]
    entries = sorted((ROOT / "leaderboard").glob("*/entry.json"))
    assert entries
    for path in entries:
        found = json.loads(path.read_text())
        assert f"## {found['kind'].capitalize()}s" in text
        assert re.search(rf"<td[^>]*>{re.escape(found['name'])}</td>", text)
        assert f"leaderboard/{path.parent.name}/entry.json)" in text
    # Tables are sorted and filtered by the script of a report's page.
    assert text.count('class="sheet sortable') == text.count("</table>") > 1
    assert '.querySelectorAll(".sortable")' in text
    # One that is not fit for the leaderboard is on no page.
    copied = tmp_path / "entries" / "quick" / "entry.json"
    copied.parent.mkdir(parents=True)
    copied.write_text(json.dumps({**found, "quick": True}))
    with pytest.raises(SystemExit, match="quick entry"):
        site("entry_board").write_pages(tmp_path, tmp_path / "entries")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, from nothing; the command ends in 0 only if all links lead somewhere."""
    for module in ("sphinx", "furo", "myst_parser"):
        pytest.importorskip(module, reason="pip install -e '.[docs]'")
    out = tmp_path_factory.mktemp("site")
    command = [sys.executable, str(SITE), "--out", str(out)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return out / "html"


@pytest.mark.slow
def test_the_site_is_built_without_a_warning(built: Path) -> None:
    for entry in CATALOGUE:
        page = (built / f"envs/{entry.id.partition('/')[2]}.html").read_text()
        assert entry.id in page
        assert "action space" in page
    assert "dsgn_small" in (built / "cards/index.html").read_text()
    assert "avsec_gym.registry.make" in (built / "api/avsec_gym.registry.html").read_text()
    commands = (built / "commands.html").read_text()
    assert all(f"avsec {words}</h2>" in re.sub("<a .*?</a>", "", commands) for words in EVERY)


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "width"), [("light", 1280), ("dark", 390)])
def test_every_kind_of_page_is_read_without_fault(
    browser: Any, built: Path, scheme: str, width: int
) -> None:
    axe = pytest.importorskip("axe_playwright_python", reason="axe-core is not installed")
    script = (resources.files(axe) / "axe.min.js").read_text()
    context = browser.new_context(viewport={"width": width, "height": 800}, color_scheme=scheme)
    for page in ONE_OF_EACH:
        tab, said = context.new_page(), list[str]()
        tab.on("console", lambda message, said=said: said.append(message.text))
        tab.on("pageerror", lambda error, said=said: said.append(str(error)))
        tab.goto((built / f"{page}.html").as_uri())
        assert said == [], (page, scheme)
        assert tab.evaluate("document.documentElement.scrollWidth") <= width, page
        assert tab.evaluate(BROKEN) == [], page
        tab.evaluate(script)
        found = [fault for fault in tab.evaluate(RULES) if fault[0] not in SPHINXS_OWN]
        assert found == [], (page, scheme)
        tab.close()
    context.close()
