"""The documentation's snippet records an episode with Gymnasium's own wrapper."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import pytest

PAGE = Path(__file__).parents[2] / "docs/environments.md"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_the_snippet_records_every_step(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("moviepy")
    (snippet,) = re.findall(r"```python\n([^`]*RecordVideo[^`]*)```", PAGE.read_text())
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(snippet, names)
    (video,) = (tmp_path / "videos").glob("*.mp4")
    capture = cv2.VideoCapture(str(video))
    count = 0
    while capture.read()[0]:
        count += 1
    pictures = int(str(names["steps"])) + 1
    # Older moviepy rounds the duration up, and shows the last picture twice.
    assert count in (pictures, pictures + 1)
    # Pictures of a drive, not of nothing: they differ, and have the size of the environment's own.
    assert capture.get(cv2.CAP_PROP_FRAME_WIDTH) > 200
