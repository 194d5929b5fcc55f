"""How many objects vehicles have in common."""

from pathlib import Path

import pytest

from studies.world.meetings import SPACINGS, meetings


@pytest.mark.slow
def test_every_object_is_counted_once_at_each_distance(tmp_path: Path) -> None:
    rows = list(meetings(1, 2, 0, tmp_path))
    assert [row.spacing for row in rows] == list(SPACINGS)
    for row in rows:
        assert sum(row.seen_by) == row.objects > 0
        assert row.shared == pytest.approx(row.seen_by[1] / row.objects, abs=1e-4)
        low, high = row.interval
        assert 0 <= low < row.shared <= high <= 1
