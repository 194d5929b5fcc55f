"""What a job's progress says."""

from __future__ import annotations

import pytest

from avsec_gym import console


def test_the_remaining_time_is_that_of_the_pace_now_not_of_what_was_there(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = [0.0]
    monkeypatch.setattr(console.time, "monotonic", lambda: now[0])
    shown = console.ProgressDisplay("rendering")
    for done in range(501):  # There from an earlier run: told within half a second.
        now[0] += 0.001
        shown(done, 1000)
    for done in range(501, 601):  # A second each.
        now[0] += 1.0
        shown(done, 1000)
    last = capsys.readouterr().err.splitlines()[-1]
    assert last == "rendering: 600 of 1000, about 400 s left"
