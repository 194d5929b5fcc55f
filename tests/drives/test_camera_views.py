"""What a car's left camera showed: kept for each frame that it looked at, and found by time."""

from __future__ import annotations

import io
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from avsec_gym.boxes import Boxes3D
from avsec_gym.drives.camera_views import CameraViews, view_until, write_views
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.scene_figures import views_row
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.drives.telling import DrivenScene
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import kitti_rig

GREY = np.full((375, 1242, 3), 90, np.uint8)


def car(elapsed: float, believed_at: float) -> Any:
    frame = SensorFrame("000000", kitti_rig().calibration, {2: GREY, 3: GREY})
    boxes = Boxes3D(
        np.array([[0.0, 1.6, 12.0]]),
        np.array([[1.5, 1.6, 4.0]]),
        np.zeros(1),
        np.ones(1),
        np.array(["Car"]),
    )
    seen = SimpleNamespace(frame=frame, perceived=SimpleNamespace(believed=boxes))
    return SimpleNamespace(
        perception=seen, belief=SimpleNamespace(time=believed_at), elapsed=elapsed
    )


def test_a_view_is_half_a_frame_with_the_believed_boxes() -> None:
    views = CameraViews(car(0.5, 0.5))
    views.look()
    picture = np.asarray(Image.open(io.BytesIO(views.pictures[500])))
    assert picture.shape == (188, 621, 3)
    # The box is seen around the middle, and nowhere else.
    drawn = np.abs(picture.astype(int) - 90).max(2) > 30
    rows, columns = np.nonzero(drawn)
    assert 240 < columns.min() < columns.max() < 380
    assert 60 < rows.min() < rows.max() < 160


def test_what_is_no_image_of_this_instant_is_not_kept() -> None:
    late = CameraViews(car(0.7, 0.5))
    late.look()
    assert late.pictures == {}
    # Nor is there one of a car that knows the truth.
    setting = DriveSetting("truth", {"perception": "truth"})
    environment = setting.environment({"source": "layouts", "count": 1})
    scene = environment.unwrapped.scenes.ids[0]  # type: ignore[attr-defined]
    assert drive(environment, DriveTask("truth", scene, "straight", 0), views=True).views == {}


def test_the_last_view_until_a_time_is_found(tmp_path: Path) -> None:
    assert view_until(tmp_path, "a/b", 1.0) is None
    write_views(tmp_path, "a/b", {0: b"first", 500: b"second", 12500: b"last"})
    assert view_until(tmp_path, "a/b", 0.4) == (0.0, b"first")
    assert view_until(tmp_path, "a/b", 0.5) == (0.5, b"second")
    assert view_until(tmp_path, "a/b", 99.0) == (12.5, b"last")
    assert view_until(tmp_path, "a/c", 1.0) is None
    (tmp_path / "views" / "a_b" / "000500.webp").write_bytes(b"x" * (2**22 + 1))
    with pytest.raises(DataError, match=r"000500\.webp"):
        view_until(tmp_path, "a/b", 1.0)


def test_a_page_shows_the_worst_drives_last_view_and_the_others_of_that_time(
    tmp_path: Path,
) -> None:
    def row(setting: str, outcome: str, duration: float) -> Any:
        return {
            "id": f"{setting}/s/straight", "setting": setting, "outcome": outcome,
            "duration": duration, "at_fault": outcome == "collision",
        }  # fmt: skip

    rows = (
        row("blind", "collision", 2.1),  # It has no camera.
        row("a", "goal", 6.0), row("b", "collision", 4.2), row("c", "stopped", 8.0),
    )  # fmt: skip
    scene = DrivenScene("s", "straight", rows)
    folder: Any = SimpleNamespace(out=tmp_path)
    assert views_row(folder, scene) is None
    for setting, times in (("a", (3500, 4000, 5000)), ("b", (0, 4000)), ("c", (0, 1000))):
        write_views(tmp_path, f"{setting}/s/straight", dict.fromkeys(times, b"image"))
    shown = views_row(folder, scene)
    assert shown is not None
    assert [each.caption for each in shown.pictures] == [
        "a, after 4.0 s", "b, after 4.0 s", "c, after 1.0 s",
    ]  # fmt: skip
    early = views_row(folder, scene, 3.9)
    assert early is not None
    assert [each.caption for each in early.pictures] == [
        "a, after 3.5 s", "b, after 0.0 s", "c, after 1.0 s",
    ]  # fmt: skip


def test_a_drive_that_is_made_again_keeps_no_views_of_before(tmp_path: Path) -> None:
    write_views(tmp_path, "a", {0: b"0", 3000: b"old"})
    write_views(tmp_path, "a", {0: b"1"})
    assert view_until(tmp_path, "a") == (0.0, b"1")
    write_views(tmp_path, "a", {})
    assert view_until(tmp_path, "a") is None
    assert list((tmp_path / "views").iterdir()) == []
