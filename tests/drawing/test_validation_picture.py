"""The status of every sensor stands in the picture whole."""

from __future__ import annotations

import numpy as np
from matplotlib.text import Text

from avsec_gym.drawing.validation_picture import draw_validation
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import camera_rig
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.repair.damage import Damage
from avsec_gym.validation.repair.damaged_scan import DamagedScan
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.thresholds import Threshold
from avsec_gym.validation.validator import Validation

RIG = camera_rig([0.0, 0.4, 0.6], focal_length=200.0, centre=(207.0, 62.0), size=(414, 125))
SYSTEM = SensorSystem((LIDAR, 2, 1, 0))
NO_POINTS = np.zeros((0, 4), np.float32)


def wall() -> SensorFrame:
    """Random dots 8 m ahead."""
    dots = np.random.default_rng(0).integers(0, 256, (125, 480, 3), np.uint8)
    images = {camera: dots[:, 5 * shift :][:, :414] for camera, shift in enumerate((0, 2, 3))}
    x, y = np.meshgrid(np.linspace(-7, 7, 150), np.linspace(-2, 2, 40))
    places = np.stack([x.ravel(), y.ravel(), np.full(x.size, 8.0), np.ones(x.size)], axis=1)
    points = (places @ RIG.calibration.camera_to_velodyne.T).astype(np.float32)
    return SensorFrame("0", RIG.calibration, images, points)


def test_the_longest_titles_are_not_cut_off() -> None:
    errors = DisparityErrors(DisparityMaps(wall().with_points(NO_POINTS), SYSTEM))
    assert len(dict(errors)) == len(SYSTEM.triples)
    statuses = dict.fromkeys(SYSTEM.sensors, SensorStatus.CANNOT_TELL)
    doubtful = Validation(
        True,
        statuses,
        errors,
        dict.fromkeys(SYSTEM.sensors, 0.5),
        dict.fromkeys(SYSTEM.triples, Threshold(0.00123, 0.00123, 0.00123, 0.00123)),
    )
    figure = draw_validation(doubtful, {LIDAR: Damage(unknown="whatever it is")})
    figure.canvas.draw()
    named = [text for text in figure.findobj(Text) if "LiDAR" in text.get_text()]
    named += [text for text in figure.findobj(Text) if text.get_text().startswith("camera")]
    assert len(named) == 8
    assert sum(text.get_text().count("0.00123") for text in named) == 4 * 4
    assert sum("too few sensors are sound" in text.get_text() for text in named) == 1
    for text in named:
        extent = text.get_window_extent()
        assert extent.x0 >= 0
        assert extent.x1 <= figure.bbox.x1
        assert extent.y1 <= figure.bbox.y1


def alarm(frame: SensorFrame, thresholds: Threshold | None = None) -> Validation:
    """Camera 1 and the LiDAR are named."""
    errors = DisparityErrors(DisparityMaps(frame, SYSTEM))
    assert errors[0, 2, 3].valid > 1000
    statuses = {
        sensor: SensorStatus.ATTACKED if sensor in (LIDAR, 1) else SensorStatus.SOUND
        for sensor in SYSTEM.sensors
    }
    given = None if thresholds is None else dict.fromkeys(SYSTEM.triples, thresholds)
    return Validation(True, statuses, errors, thresholds=given)


def test_what_is_beyond_its_threshold_says_so() -> None:
    frame = wall()
    image = frame.image(1).copy()
    image[:, 100:200] = 0
    said = alarm(frame.with_image(1, image), Threshold(error=0.99, hole_share=0.0012))
    (first, *_) = said.exceeded
    assert (first.share, first.threshold) == ("hole_share", 0.0012)
    title = draw_validation(said).axes[1].get_title(loc="left")
    assert f"holes {first.value:.3g} > 0.0012" in title
    assert "≤ 0.99" in title
    # The other two shares were not to judge.
    assert title.count("≤") + title.count(">") == 2
    assert ">" not in draw_validation(alarm(frame)).axes[1].get_title(loc="left")


def test_what_raised_the_alarm_comes_first_whosever_reference_it_is() -> None:
    frame = wall()
    said = alarm(frame)
    told = (0, 1, 2)
    assert dict(said.errors)[told].valid > 0
    thresholds = {
        triple: Threshold(error=-1.0 if triple == told else 1.0) for triple in SYSTEM.triples
    }
    said = Validation(True, said.statuses, said.errors, thresholds=thresholds)
    assert [comparison.triple for comparison in said.exceeded] == [told]
    titles = [axes.get_title(loc="left") for axes in draw_validation(said).axes[1::2]]
    assert [title.partition("\n")[0] for title in titles] == [
        "LiDAR against camera 2, seen by camera 1",
        "LiDAR against camera 2, seen by camera 0",
        "LiDAR against camera 1, seen by camera 0",
        "camera 2 against camera 1, seen by camera 0",
    ]


def test_damage_is_magenta() -> None:
    frame = wall()
    pixels = np.zeros((125, 414), bool)
    pixels[30:60, 100:160] = True
    bogus = np.abs(frame.points[:, 1]) < 0.5
    damage = {
        1: Damage(pixels),
        LIDAR: Damage(scan=DamagedScan(bogus, np.zeros((140, 1800), bool))),
    }
    said = alarm(frame)
    plain, shown = (
        {
            axes.get_title(loc="left"): axes.get_images()[0].get_array().astype(int)
            for axes in draw_validation(said, found).axes[::2]
        }
        for found in (None, damage)
    )
    camera = shown["camera 1: attacked, 3.5 % of its pixels"]
    changed = (camera != plain["camera 1: attacked"]).any(axis=2)
    assert changed[pixels].mean() > 0.9
    assert not changed[:28].any()
    assert not changed[:, :98].any()
    magenta = (shown[f"LiDAR: attacked, {bogus.sum()} points"] == (255, 0, 255)).all(axis=2)
    columns = np.flatnonzero(magenta.any(axis=0))
    # Half a metre to each side, 8 m ahead: 200 pixels are one.
    assert 207 - 200 / 16 - 3 < columns.min() < columns.max() < 207 + 200 / 16 + 3
    np.testing.assert_array_equal(shown["camera 2: sound"], plain["camera 2: sound"])
