"""What is reported of a fit: which of the judged frames it was made of."""

from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.commands.fit_remarks import clean_data, fitted_among
from avsec_gym.frame import SensorFrame
from avsec_gym.validation.recordings import RecordedFrame


def frames(drive: str, numbers: range, several: bool = False) -> list[RecordedFrame]:
    """Frames of a drive, which their ids name where there are several drives."""

    def never() -> SensorFrame:
        raise AssertionError("nothing is read")

    before = f"{drive}/" if several else ""
    return [RecordedFrame(f"{before}{number:010d}", never, drive) for number in numbers]


@pytest.mark.parametrize(
    ("recording", "several", "expected"),
    [
        ("day/drive_1", False, 2),
        ("day", True, 2),
        (".", True, 2),
        ("day/drive_2", False, 0),
        ("other", True, 0),
    ],
)
def test_frames_are_known_again_in_the_drive_its_day_and_its_root(
    tmp_path: Path, recording: str, several: bool, expected: int
) -> None:
    """A fit on frames 0 to 4 of a drive, and frames 3 to 9 to be judged."""
    data = clean_data(tmp_path / "day" / "drive_1", frames("drive_1", range(5)))
    judged = frames("drive_1", range(3, 10), several)
    assert fitted_among(data, tmp_path / recording, judged) == expected


def test_of_a_file_that_names_no_recording_nothing_is_known(tmp_path: Path) -> None:
    assert fitted_among({"first": "0", "last": "9"}, tmp_path, frames("drive_1", range(5))) == 0
