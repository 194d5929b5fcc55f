"""Curves of trainings are thinned without losing a validation."""

from __future__ import annotations

import json
from pathlib import Path

from avsec_gym.experiments.json_rows import as_json, row_json
from studies.perception.training_curves import NetworkCurves, joined, main, thinned_curves


def rows() -> list[dict[str, object]]:
    losses = [{"step": 20 * i, "losses": {"total": float(i)}} for i in range(1, 8)]
    metrics = [{"step": 70, "seconds": 90.0, "metrics": {"Car_3d_ap11": 5.0, "loss": float("nan")}}]
    return [*losses[:4], *metrics, *losses[4:]]  # type: ignore[list-item]


def test_losses_are_means_and_every_validation_stays() -> None:
    result = thinned_curves(rows(), most=3)
    assert as_json(result.losses) == [
        {"step": 60, "total": 2.0}, {"step": 120, "total": 5.0}, {"step": 140, "total": 7.0}
    ]  # fmt: skip
    assert as_json(result.metrics) == [
        {"step": 70, "minutes": 1.5, "Car_3d_ap11": 5.0, "loss": None}
    ]
    assert [point.values["total"] for point in thinned_curves(rows()).losses] == [*range(1, 8)]
    assert NetworkCurves.from_json(row_json(result)) == result


def test_a_training_that_went_on_continues_the_curve() -> None:
    both = joined([rows(), rows()])
    assert [row["step"] for row in both if "metrics" in row] == [70, 210]
    assert [row["seconds"] for row in both if "metrics" in row] == [90.0, 180.0]
    result = thinned_curves(both)
    assert result.begins == [140]
    assert [point.step for point in result.losses] == [20 * i for i in range(1, 15)]


def test_the_command_draws_what_it_tells(tmp_path: Path) -> None:
    folder, out, figure = (tmp_path / name for name in ("run", "curves.json", "curves.png"))
    assert main([f"dsgn={folder}"]) == 1
    assert main(["dsgn"]) == 1
    folder.mkdir()
    lines = "".join(json.dumps(row) + "\n" for row in rows())
    (folder / "curves.jsonl").write_text(lines)
    assert main([f"dsgn={folder}", "--json", str(out), "--figure", str(figure)]) == 0
    assert json.loads(out.read_text())["dsgn"]["metrics"][0]["step"] == 70
    assert figure.read_bytes().startswith(b"\x89PNG")
    assert main([f"dsgn={folder},{folder}", "--json", str(out)]) == 0
    assert [row["step"] for row in json.loads(out.read_text())["dsgn"]["metrics"]] == [70, 210]


def test_networks_that_are_not_trained_anew_stay(tmp_path: Path) -> None:
    folder, out = tmp_path / "run", tmp_path / "curves.json"
    folder.mkdir()
    (folder / "curves.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows()))
    before = {"psmnet": {"losses": [], "metrics": []}, "dsgn": "of before"}
    out.write_text(json.dumps(before))
    assert main([f"dsgn={folder}", "--others", str(out), "--json", str(out)]) == 0
    after = json.loads(out.read_text())
    assert after["psmnet"] == before["psmnet"]
    assert after["dsgn"]["metrics"][0]["step"] == 70
    out.write_text("no JSON")
    assert main([f"dsgn={folder}", "--others", str(out), "--json", str(out)]) == 1
    assert out.read_text() == "no JSON"


def test_a_network_goes_on_with_the_curves_of_an_earlier_result(tmp_path: Path) -> None:
    folder, out = tmp_path / "run", tmp_path / "curves.json"
    folder.mkdir()
    (folder / "curves.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows()))
    asked = [f"dsgn=+{folder}", "--others", str(out), "--json", str(out)]
    out.write_text("{}")
    assert main(asked) == 1
    assert main([f"dsgn={folder},{folder}", "--json", str(out)]) == 0
    assert main(asked) == 0
    after = json.loads(out.read_text())["dsgn"]
    assert after["begins"] == [140, 280]
    assert [(row["step"], row["minutes"]) for row in after["metrics"]] == [
        (70, 1.5), (210, 3.0), (350, 4.5)
    ]  # fmt: skip
    assert [row["step"] for row in after["losses"]] == [20 * i for i in range(1, 22)]


def test_runs_below_a_folder_are_found_by_their_names(tmp_path: Path) -> None:
    out = tmp_path / "curves.json"
    for name in ("dsgn", "dsgn_2", "yolo", "my_network"):
        (tmp_path / name).mkdir()
        text = "".join(json.dumps(row) + "\n" for row in rows())
        (tmp_path / name / "curves.jsonl").write_text(text)
    assert main(["--below", str(tmp_path), "--json", str(out)]) == 0
    curves = json.loads(out.read_text())
    assert list(curves) == ["dsgn", "yolo"]
    assert [row["step"] for row in curves["dsgn"]["metrics"]] == [70, 210]
    assert main(["--below", str(tmp_path / "dsgn")]) == 1
    assert main([]) == 1
