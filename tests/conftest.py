"""Fixtures for every test."""

from __future__ import annotations

import signal
from pathlib import Path

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

SHARED = Path(__file__).resolve().parents[2] / "shared"


@pytest.fixture(scope="session")
def shared() -> Path:
    """Real data that may not be copied into the repository; tests skip where it is absent."""
    if not (SHARED / "kitti").is_dir():
        pytest.skip("real KITTI data is not here (../shared, beside the repository)")
    return SHARED


@pytest.fixture
def undrawn_curves(monkeypatch: pytest.MonkeyPatch) -> None:
    """For trainings of a few steps: their pictures would take longer than they do."""
    curves = "avsec_gym.perception.training.curves"
    monkeypatch.setattr(f"{curves}.draw_curves", lambda rows, path: None)
