"""Fixtures for every test."""

from __future__ import annotations

import hashlib
import os
import shutil
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

# A busy machine is no fault of the code: no example has a time limit of its own.
settings.register_profile("avsec", deadline=None)
settings.load_profile("avsec")

# A shell that starts the tests in the background has them ignore Ctrl-C, nohup has them ignore that
# their terminal is gone, and what they start ignores it, too.
for number, default in (
    (signal.SIGINT, signal.default_int_handler),
    (signal.SIGHUP, signal.SIG_DFL),
    (signal.SIGTERM, signal.SIG_DFL),
):
    if signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, default)

FRONT_DOOR = ("tests/test_first_steps", "tests/test_notebooks", "tests/test_site", "tests/report")
"""Tests of what newcomers meet; where time is short, their slow ones come before all others."""
BEGUN = time.monotonic()
CHROMIUM_OPTIONS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip


@pytest.hookimpl(tryfirst=True)
def pytest_itemcollected(item: pytest.Item) -> None:
    """Processes that share the tests know them by their names: no address is in one."""
    if " at 0x" in item.nodeid:
        raise pytest.UsageError(f"{item.nodeid}: its parameter's name is an address in memory")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """With `ROUND` set, the front door comes first, then files in that round's own order.

    Tests beyond `ROUND_SECONDS` are left out: so none is left out every time.
    """
    turn = os.environ.get("ROUND", "")

    def place(item: pytest.Item) -> tuple[bool, bytes]:
        file = item.nodeid.split("::")[0]
        return not file.startswith(FRONT_DOOR), hashlib.sha256((turn + file).encode()).digest()

    if turn:
        items.sort(key=place)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Tests begin within `ROUND_SECONDS` of the session's start, where that is set."""
    limit = float(os.environ.get("ROUND_SECONDS", "inf"))
    if time.monotonic() - BEGUN > limit:
        pytest.skip(f"the {limit:.0f} s of this round are over")


SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(scope="session")
def shared() -> Path:
    """Real data that may not be copied into the repository; tests skip where it is absent."""
    if not (SHARED / "kitti").is_dir():
        pytest.skip("real KITTI data is not here (../shared, beside the repository)")
    return SHARED


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """Debian's chromium, or Chrome, where one is installed."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("there is no chromium (Debian's package)")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=CHROMIUM_OPTIONS)
        yield browser
        browser.close()


@pytest.fixture
def undrawn_curves(monkeypatch: pytest.MonkeyPatch) -> None:
    """For trainings of a few steps: their pictures would take longer than they do."""
    curves = "avsec_gym.perception.training.curves"
    monkeypatch.setattr(f"{curves}.draw_curves", lambda rows, path: None)
