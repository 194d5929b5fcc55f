"""`avsec world`: exit codes, JSON, and a run that is killed."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.kitti import write_calibration, write_labels
from avsec_gym.rig import SensorRig, kitti_rig
from avsec_gym.world.export import Sensors, make_data_set, suite_recipe

from .conftest import Texts, contents

DONE, BAD_DATA, BAD_USAGE, IN_PART = 0, 1, 2, 3


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ("make --suite street --out {0} --frames 0", BAD_USAGE, "from 1 to 1,000,000, got 0"),
        ("make --suite raw --out {0} --frames 1000001", BAD_USAGE, "from 1 to 1,000,000, got 1"),
        (
            f"make --suite street --out {{0}} --frames {10**23}",
            BAD_USAGE,
            "from 1 to 1,000,000, got 1",
        ),
        ("make --suite street --out {0} --seed -1", BAD_USAGE, "0 or more, got -1"),
        ("make --suite street --out {0} --workers 0", BAD_USAGE, "1 worker or more"),
        ("make --suite street --out {0} --cameras 2 5", BAD_USAGE, "cameras are some of"),
        ("make --suite street --out {0} --previous 9", BAD_USAGE, "0 to 3"),
        ("make --suite raw --out {0} --vehicles 2", BAD_USAGE, "--vehicles does not belong"),
        ("make --suite street --out {1}", BAD_DATA, "This is a file"),
        ("twin --kitti {2} --out {0} --ids 000107", BAD_DATA, "There is no such folder"),
        ("twin --kitti {3} --out {0} --ids 107", BAD_USAGE, "six digits"),
        ("twin --kitti {3} --out {0} --ids 000107", BAD_USAGE, "no label and calibration"),
        ("twin --kitti {3} --out {0} --limit 0", BAD_USAGE, "--limit is 1 or more"),
        ("twin --kitti {3} --out {0} --cameras 4", BAD_USAGE, "cameras are some of"),
        (
            "twin --kitti {3} --out {0} --style city --road-type highway",
            BAD_USAGE,
            "--style city is no",
        ),
        ("verify {2}", BAD_DATA, "There is no such folder"),
        ("verify {3}", BAD_DATA, "no manifest"),
    ],
)
def test_refusals(
    arguments: str,
    code: int,
    said: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "file").write_text("text")
    kitti = tmp_path / "kitti"
    write_labels(kitti / "training/label_2/000003.txt", Boxes3D.empty())
    write_calibration(kitti / "training/calib/000003.txt", kitti_rig().calibration)
    places = (tmp_path / "out", tmp_path / "file", tmp_path / "absent", kitti)
    words = arguments.format(*places).split()
    assert run(["world", *words]) == code
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_help_names_the_verbs(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["world", "--help"]) == 0
    shown = capsys.readouterr().out
    assert all(verb in shown for verb in ("make", "twin", "verify"))


def test_verify(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make_data_set(Texts(), tmp_path, workers=1)
    assert run(["world", "verify", str(tmp_path)]) == DONE
    (tmp_path / "first/1.txt").write_text("b")
    capsys.readouterr()
    assert run(["world", "verify", str(tmp_path), "--json"]) == BAD_DATA
    assert json.loads(capsys.readouterr().out)["changed"] == ["first/1.txt"]


def test_a_rig_of_ones_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    made: list[Any] = []
    monkeypatch.setattr(
        "avsec_gym.commands.world._make", lambda recipe, *rest: made.append(recipe) or 0
    )
    words = ["world", "make", "--suite", "street", "--out", str(tmp_path)]
    assert run([*words, "--rig", "0", "0.27", "-0.27", "0.54"]) == DONE
    assert run([*words, "--assets", "judge"]) == DONE
    assert [recipe.assets.value for recipe in made] == ["all", "judge"]
    baselines = [recipe.sensors.rig.calibration.baseline(2, 3) for recipe in made]
    assert run([*words, "--rig", "0", "0", "0", "0"]) == BAD_USAGE
    assert baselines == pytest.approx([0.81, kitti_rig().calibration.baseline(2, 3)])


@pytest.mark.slow
def test_full_size(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "street"
    words = ["world", "make", "--suite", "street", "--frames", "1", "--out", str(out)]
    assert run([*words, "--json"]) == DONE
    assert json.loads(capsys.readouterr().out)["made"] == 1
    assert run(["world", "verify", str(out)]) == DONE
    twin = ["world", "twin", "--kitti", str(out), "--out", str(tmp_path / "twin"), "--no-lidar"]
    assert run(twin) == DONE
    labels = [root / "training/label_2/000000.txt" for root in (out, tmp_path / "twin")]
    first, second = (path.read_text().split("\n")[0].split()[8:] for path in labels)
    assert first == second
    (out / "training/label_2/000000.txt").write_text("Car what\n")
    assert run([*twin[:5], str(tmp_path / "broken"), "--no-lidar"]) == BAD_DATA


@pytest.mark.slow
def test_a_killed_run_is_completed(mixed: Path, tmp_path: Path, rig: SensorRig) -> None:
    script = (
        "import sys\n"
        "from avsec_gym.rig import KITTI_CAMERAS, camera_rig\n"
        "from avsec_gym.world.export import Sensors, make_data_set, suite_recipe\n"
        "rig = camera_rig(KITTI_CAMERAS, focal_length=721.5377 / 3, centre=(202.9, 57.3),"
        " size=(414, 125))\n"
        "recipe = suite_recipe('mixed', 2, seed=1, sensors=Sensors(rig=rig), previous=1)\n"
        "make_data_set(recipe, sys.argv[1], workers=1)\n"
    )
    root = tmp_path / "killed"
    with subprocess.Popen([sys.executable, "-c", script, str(root)]) as process:
        deadline = time.monotonic() + 120
        while not (root / "training/label_2/000000.txt").exists():
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.02)
        process.send_signal(signal.SIGKILL)
    recipe = suite_recipe("mixed", 2, seed=1, sensors=Sensors(rig=rig), previous=1)
    report = make_data_set(recipe, root, workers=1)
    assert (report.made, report.kept) == (1, 1)
    assert contents(root) == contents(mixed)
