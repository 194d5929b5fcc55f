"""What is shipped is judged as validators judge, and the page says what came out."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.writing import write_raw_frame
from avsec_gym.rig import KITTI_SIZE, kitti_rig
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.likelihood.maximum_likelihood import read_likelihood_model
from avsec_gym.validation.shipped import SHIPPED_SYSTEMS, origin_of, shipped_file, stale
from avsec_gym.validation.state_posterior import state_vectors
from avsec_gym.validation.threshold_validator import ThresholdValidator
from avsec_gym.validation.thresholds import read_threshold_table
from avsec_gym.world.assets import Assets
from studies.chapter3.shipped_fits import page
from studies.chapter3.shipped_fits.confirm import main as confirm
from studies.chapter3.shipped_fits.evidence import (
    SYSTEM,
    evidence_of,
    measured,
    sample_id,
    shipped_drives,
)
from studies.chapter3.shipped_fits.fit import main as fit
from studies.chapter3.shipped_fits.fit import write_fits
from studies.chapter3.shipped_fits.judge import (
    one_at_a_time,
    said_by_likelihood,
    said_by_thresholds,
)
from studies.index import without_remark

RATE = 0.05


def dots(number: int) -> SensorFrame:
    """Cameras and LiDAR of KITTI's rig before a wall of grey dots."""
    rig, depth = kitti_rig(), 12.0
    right = {camera: float(rig.calibration.camera_centre(camera)[0]) for camera in (1, 2, 3)}
    shift = {camera: round(721.5 * (x - right[2]) / depth) for camera, x in right.items()}
    rng = np.random.default_rng(number)
    picture = rng.integers(40, 140, (94, 330, 1), np.uint8).repeat(4, 0).repeat(4, 1).repeat(3, 2)
    images = {camera: picture[:375, shift[camera] :][:, :1242] for camera in right}
    x, y = np.meshgrid(np.linspace(-9, 9, 400), np.linspace(-2, 2, 60))
    places = np.stack([x.ravel(), y.ravel(), np.full(x.size, depth), np.ones(x.size)], axis=1)
    points = (places @ rig.calibration.camera_to_velodyne.T).astype(np.float32)
    return SensorFrame(f"{number:010d}", rig.calibration, images, points)


@pytest.mark.parametrize(
    "system",
    [
        pytest.param(system, marks=[] if system.sensors == (LIDAR, 3, 2) else pytest.mark.slow)
        for system in SHIPPED_SYSTEMS
    ],
    ids=str,
)
def test_what_is_counted_is_what_validators_say(system: SensorSystem) -> None:
    frame, depth = dots(1), PairDepth("sgbm")
    bogus = frame.with_points(frame.points[::2] * np.float32(0.5))
    bright = frame.image(3).copy()
    bright[100:300, 300:700] = 255
    attacked = dict.fromkeys(SYSTEM.sensors, frame)
    attacked |= {LIDAR: bogus, 3: frame.with_image(3, bright)}
    states = one_at_a_time(SYSTEM)
    rows = measured(StateEvidence(frame, attacked, SYSTEM, depth), states)
    own = evidence_of(rows[None], SYSTEM, states).of(system)
    files = [shipped_file(kind, system) for kind in ("thresholds", "likelihood")]
    table, model = read_threshold_table(files[0]), read_likelihood_model(files[1])
    validators = ThresholdValidator(table, RATE), LikelihoodValidator(model, RATE)
    alarms = []
    for number, state in enumerate(own.states):
        shown = frame
        for sensor in (sensor for sensor, hit in zip(system.sensors, state, strict=True) if hit):
            tampered = attacked[sensor]
            shown = (
                shown.with_points(tampered.points)
                if sensor == LIDAR
                else shown.with_image(int(sensor), tampered.image(int(sensor)))
            )
        for validator, said in zip(
            validators,
            (
                said_by_thresholds(table, own.shares[:, number], RATE),
                said_by_likelihood(model, own.elements[:, number], RATE),
            ),
            strict=True,
        ):
            found = validator.validate(shown)
            alarms.append(found.alarm)
            assert bool(said[0][0]) == found.alarm
            if said[1] is not None:
                assert {system.sensors[index] for index in said[1][0]} == found.attacked
    assert any(alarms)


def test_the_command_fits_and_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    frames, drive = 12, tmp_path / "2026_01_01" / "2026_01_01_drive_0001_sync"
    write_raw_calibration(drive.parent, kitti_rig().calibration, image_size=KITTI_SIZE)
    write_raw_frame(drive, 0, dots(0))
    # Of all but the first frame, samples are there already: their files' content is not read.
    rng = np.random.default_rng(0)
    shape = (2 ** len(SYSTEM), 32)
    lines = []
    for number in range(1, frames):
        write_raw_frame(drive, number, SensorFrame(
            f"{number:010d}", kitti_rig().calibration,
            {camera: np.zeros((4, 4, 3), np.uint8) for camera in (1, 2, 3)},
            np.zeros((1, 4), np.float32),
        ))  # fmt: skip
        row = rng.uniform(0.01, 0.2, shape)
        lines.append(
            json.dumps({"id": sample_id(f"{number:010d}", 3, "fitted"), "measured": row.tolist()})
        )
    samples = tmp_path / "samples.jsonl"
    samples.write_text("\n".join(lines) + "\n")
    module = "studies.chapter3.shipped_fits.fit"
    monkeypatch.setattr(f"{module}.shipped_drives", lambda count, seed, part: tmp_path)
    monkeypatch.setattr(f"{module}._LEAST_FRAMES", frames)
    write_fits(frames, 3, samples, tmp_path / "fits")
    assert len(samples.read_text().splitlines()) == frames
    for system in SHIPPED_SYSTEMS:
        table = read_threshold_table(shipped_file("thresholds", system, tmp_path / "fits"))
        model = read_likelihood_model(shipped_file("likelihood", system, tmp_path / "fits"))
        assert len(table) == len(model.clean_scores) == frames
        assert "seed 3, 12 frames; not on this vehicle" in origin_of(model.on)
    every = read_threshold_table(shipped_file("thresholds", SYSTEM, tmp_path / "fits"))
    rows = [json.loads(line)["measured"] for line in samples.read_text().splitlines()]
    told = evidence_of(np.array(rows), SYSTEM, state_vectors(len(SYSTEM)))
    _check_confirmation(tmp_path / "fits", monkeypatch)
    assert sorted(every.shares.ravel()) == pytest.approx(sorted(told.shares[:, 0].ravel()))


def _check_confirmation(fits: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of other sources hold for today's if the same is measured, else they are refused."""
    module = "studies.chapter3.shipped_fits.confirm"
    asked: list[Assets] = []

    def drives(count: int, seed: int, part: str, assets: Assets) -> Path:
        asked.append(assets)
        return fits.parent

    monkeypatch.setattr(f"{module}.shipped_drives", drives)
    path = shipped_file("thresholds", SYSTEM, fits)
    content = json.loads(path.read_text())
    content["fitted_on"]["data"]["sources"] = "0123456789abcdef"
    path.write_text(json.dumps(content))
    assert stale(read_threshold_table(path).on)
    assert confirm(["--frames", "1", "--fits", str(fits)]) == 0
    assert not stale(read_threshold_table(path).on)
    # Those that the package ships were fitted before there was a choice of assets.
    del content["fitted_on"]["data"]["assets"]
    content["shares"][0][0][0] += 0.01
    path.write_text(json.dumps(content))
    assert confirm(["--frames", "1", "--fits", str(fits)]) == 1
    assert stale(read_threshold_table(path).on)
    assert asked == [Assets.TRAIN, Assets.ALL]


def test_too_few_frames_and_other_seeds_are_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert fit(["--frames", "99", "--out", str(tmp_path)]) == 1
    with pytest.raises(ConfigurationError, match="from 0 to 999"):
        shipped_drives(1, 1000, "fitted")


def test_the_page_says_what_came_out(tmp_path: Path) -> None:
    results = Path(__file__).parents[3] / "studies" / "results"
    made = json.loads((results / "shipped_fits.json").read_text())
    assert page.main([str(results / "shipped_fits.json"), "--out", str(tmp_path / "page.md")]) == 0
    told = (tmp_path / "page.md").read_text()
    # The committed page is that of the committed result.
    assert told == without_remark((results / "shipped_fits.md").read_text())
    assert "not on this vehicle" in told
    for system in made["systems"]:
        unattacked = system["by"]["thresholds"]["no attack"]["alarms"]
        assert f"({unattacked['count']} of {unattacked['of']})" in told
    (tmp_path / "other.json").write_text("[]")
    assert page.main([str(tmp_path / "other.json"), "--out", str(tmp_path / "no.md")]) == 1
