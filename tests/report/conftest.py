"""A small run whose detections are drawn from a seed, and what is made of it; once a session."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import pytest

from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.soundness import digests

if TYPE_CHECKING:
    from avsec_gym.report.run_report import RunReport

SCENES = 6


@pytest.fixture(scope="session")
def drawn() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(Path(__file__).parent)
        import drawn_run

        yield drawn_run


@pytest.fixture(scope="session")
def frames(drawn: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Path:
    root: Path = drawn.write_frames(tmp_path_factory.mktemp("frames"), SCENES)
    return root


@pytest.fixture(scope="session")
def run(drawn: ModuleType, frames: Path, tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """A finished run."""
    root = tmp_path_factory.mktemp("run") / "whole"
    run_experiments([drawn.SOME], Configuration(str(frames)), root, workers=0, threads=1)
    return RunFolder.open(root)


@pytest.fixture(scope="session")
def torso(run: RunFolder, tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """The same run cut short: the last scene is missing, of patches nearly all, and one failed."""
    root = tmp_path_factory.mktemp("run") / "torso"
    shutil.copytree(run.path, root)
    with closing(sqlite3.connect(root / "results.sqlite")) as database, database:
        database.execute("PRAGMA foreign_keys = ON")
        last = f'%"scenario":"{SCENES - 1:06d}"%'
        database.execute("DELETE FROM cells WHERE arguments LIKE ?", (last,))
        database.execute(
            "DELETE FROM cells WHERE arguments LIKE '%patch-specific%'"
            " AND arguments NOT LIKE '%\"000000\"%'"
        )
        broken = '%"attack":"patch-random"%"dsgn"%"000003"%'
        (cell,) = database.execute(
            "SELECT cell FROM cells WHERE arguments LIKE ?", (broken,)
        ).fetchone()
        for table in ("drives", "detections", "measurements", "timings"):
            database.execute(f"DELETE FROM {table} WHERE cell = ?", (cell,))
        database.execute(
            "UPDATE cells SET status = 'failed', error = 'the <printer> is out of paper'"
            " WHERE cell = ?",
            (cell,),
        )
        database.execute(
            "UPDATE digests SET digest = ? WHERE cell = ?", (digests(database)[cell], cell)
        )
    return RunFolder.open(root)


@pytest.fixture(scope="session")
def report(run: RunFolder) -> RunReport:
    from avsec_gym.report.run_report import run_report

    return run_report(run)


@pytest.fixture(scope="session")
def page(run: RunFolder, drawn: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of the finished run, with pictures."""
    from avsec_gym.experiments.chapter5 import attacked_episodes, patch_spreads
    from avsec_gym.report.html import html_page
    from avsec_gym.report.run_report import run_report
    from avsec_gym.runs.section import ReportRequest

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(attacked_episodes, "AttackedEpisodes", drawn.DrawnEpisodes)
        patch.setattr(patch_spreads, "PatchSpreads", drawn.DrawnSpreads)
        report = run_report(run, ReportRequest(pictures=3))
    assert not report.problems
    path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(html_page(report))
    return path
