"""`avsec error-model`: from label and result files to a model, and back to frames."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from avsec_gym.cli import run
from avsec_gym.closed_loop.error_model.model import read_error_model
from avsec_gym.closed_loop.error_model.stored_frames import stored_frames

CAR = "Car 0.00 0 -10 600.00 180.00 650.00 220.00 1.50 1.70 4.20 {x:.2f} 1.65 {z:.2f} -1.57"


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    """Two drives of ten frames; the near car is always found, half a metre too far."""
    vehicle, results = tmp_path / "data" / "vehicle_0", tmp_path / "results"
    for name in ("label_2", "scene", "calib"):
        (vehicle / "training" / name).mkdir(parents=True)
    (tmp_path / "data" / "objects").mkdir()
    results.mkdir()
    for number in range(20):
        id, drive, frame = f"{number:06d}", number // 10, number % 10
        cars = [CAR.format(x=0.0, z=12.0), CAR.format(x=3.0, z=45.0)]
        (vehicle / "training" / "label_2" / f"{id}.txt").write_text("\n".join(cars) + "\n")
        objects = [{"actor": 7, "moving": True}, {"actor": 3, "moving": False}]
        scene = {"road_type": "street", "objects": objects}
        (vehicle / "training" / "scene" / f"{id}.json").write_text(json.dumps(scene))
        instant = {"drive": drive, "frame": frame}
        (tmp_path / "data" / "objects" / f"{id}.json").write_text(json.dumps(instant))
        found = [CAR.format(x=0.0, z=12.5 + 0.01 * frame) + " 0.90"]
        found += [CAR.format(x=0.0, z=30.0) + " 0.20"]
        (results / f"{id}.txt").write_text("\n".join(found) + "\n")
    return vehicle, results


def test_fitted_checked_and_held_against_another_detector(
    folders: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    vehicle, results = folders
    out = tmp_path / "model.json"
    files = ["--kitti", str(vehicle), "--detections", str(results)]
    fit = ["error-model", "fit", *files, "--out", str(out), "--detector", "mine"]
    assert run([*fit, "--json"]) == 0
    card = json.loads(capsys.readouterr().out)
    assert (card["objects"], card["found"], card["ghosts"]) == (40, 20, 0)
    assert (card["drives"], card["detector"]) == (2, "mine")
    model = read_error_model(out)
    assert model.spreads["radial"].bias == pytest.approx(0.545, abs=0.05)
    check = ["error-model", "check", str(out), *files]
    assert run([*check, "--json"]) == 3
    rows = json.loads(capsys.readouterr().out)["ranges"]
    assert [row["found"] for row in rows] == [1.0, None, 0.0]
    assert {row["answer"] for row in rows} == {"cannot tell"}, "two drives show little"
    # With its unsure boxes it is another detector: it has a ghost in every frame.
    assert run([*check, "--score-threshold", "0.1"]) == 3
    assert "differs" in capsys.readouterr().out
    assert run(fit) == 1  # Nothing is overwritten.
    assert run([*check, "--score-threshold", "2"]) == 2
    assert run([*check, "--limit", "0"]) == 2


def test_frames_of_a_drive_follow_one_another(folders: tuple[Path, Path]) -> None:
    frames = stored_frames(*folders)
    data = folders[0].parent
    assert [frame.drive for frame in frames] == [f"{data} 0"] * 10 + [f"{data} 1"] * 10
    shutil.copytree(folders[0], data / "vehicle_1")
    other = stored_frames(data / "vehicle_1", folders[1])[0]
    assert other.drive == frames[0].drive
    assert other.vehicle != frames[0].vehicle
    assert frames[13].time == pytest.approx(0.3)
    actors = frames[0].actors
    assert actors is not None
    assert actors.tolist() == [7, 3]
    for folder in ("objects", "vehicle_0/training/scene"):
        for path in (folders[0].parent / folder).iterdir():
            path.unlink()
    alone = stored_frames(*folders)
    assert alone[13].drive.endswith(" 000013")
    assert alone[13].actors is None
