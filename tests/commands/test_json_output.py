"""Whatever programs read names its schema and the schema's version."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import avsec_gym
from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import every_command, run
from avsec_gym.commands.arguments import options
from avsec_gym.frame import SensorFrame
from avsec_gym.json_schemas import SCHEMAS, with_schema
from avsec_gym.kitti.labels import write_detections
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.rig import kitti_rig
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.commonroad import write_commonroad

PACKAGE = Path(avsec_gym.__file__).parent
WITH_JSON = [
    name
    for name, command in every_command().items()
    if "--json" in {option.flag for option in options(command)}
]


def schema_of(command: str) -> str:
    """Its words; an entry of the benchmark is one document, whatever is entered."""
    return "benchmark.entry" if command.startswith("benchmark ") else command.replace(" ", ".")


def test_every_command_with_json_has_a_schema_of_its_own() -> None:
    for command in WITH_JSON:
        name = schema_of(command)
        own = [schema for schema in SCHEMAS if schema == name or schema.startswith(f"{name}.")]
        assert own, f"avsec {command} --json has no schema"
    named = set(map(schema_of, WITH_JSON))
    for schema in SCHEMAS:
        assert schema in named or schema.rpartition(".")[0] in named, f"no command writes {schema}"


def test_no_command_prints_json_in_another_way() -> None:
    """The console takes a schema with everything; nothing goes past it to standard output."""
    for path in (PACKAGE / "commands").glob("*.py"):
        if path.name == "console.py":
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                assert node.func.attr not in ("write",) or "stdout" not in ast.unparse(node), path
                if node.func.attr in ("print_json", "print_json_line"):
                    first = node.args[0]
                    if isinstance(first, ast.Constant):
                        assert first.value in SCHEMAS, path
            assert not (isinstance(node, ast.Name) and node.id == "print"), path


def test_the_documentation_lists_every_schema() -> None:
    page = (PACKAGE.parent / "docs" / "runs.md").read_text()
    listed = re.findall(r"^\| `avsec\.([a-z_.-]+)/(\d+)` \|", page, re.MULTILINE)
    assert {name: int(version) for name, version in listed} == SCHEMAS


def test_a_schema_comes_first_and_once() -> None:
    stamped = with_schema("plan", {"file": "a.xml", "schema": "an old one"})
    assert list(stamped.items()) == [("schema", "avsec.plan/1"), ("file", "a.xml")]


@pytest.fixture(scope="module")
def there(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A KITTI folder with one frame, results for it, and a planning problem."""
    root = tmp_path_factory.mktemp("data")
    car = Boxes3D(
        [[6.0, 1.65, 25.0]], [[1.5, 1.6, 4.0]], [-np.pi / 2], [0.9], ["Car"],
        box2d=[[700.0, 160.0, 780.0, 230.0]], truncation=[0.0], occlusion=[0], alpha=[0.0],
    )  # fmt: skip
    images = {camera: np.full((375, 1242, 3), 90, np.uint8) for camera in (2, 3)}
    frame = SensorFrame("000001", kitti_rig().calibration, images)
    write_object_frame(root / "kitti/training", frame, car)
    write_detections(root / "found/000001.txt", car)
    problem = build_planning_scenario(Boxes3D.empty(), road_type=RoadType.STREET, id="free")
    write_commonroad(problem, root / "free.xml")
    (root / "broken.xml").write_text("<commonRoad>")
    return root


def no_constant(word: str) -> Any:
    raise AssertionError(f"{word} is no JSON")


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ("evaluate --kitti {kitti}", 0),
        ("evaluate --kitti {kitti} --detections {found} --sweep 1 --out {out}", 0),
        ("detect --kitti {kitti} --detector oracle --out {out}", 0),
        ("ap --kitti {kitti} --detections {found}", 0),
        ("ap --kitti {kitti} --detections {found} --out {out}.json", 0),
        ("data check {kitti}", 0),
        ("experiments", 0),
        ("experiments pipeline --scenarios {kitti}", 0),
        ("plan {there}/free.xml {there}/broken.xml", 3),
        ("run pipeline --scenarios {kitti} --detector oracle --workers 0 --out {out}", 0),
    ],
)
def test_what_is_printed_can_be_read(
    words: str, code: int, there: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    places = {"kitti": there / "kitti", "found": there / "found", "there": there, "out": out}
    typed = words.format(**places).split()
    assert run([*typed, "--json"]) == code
    text = capsys.readouterr().out
    name = next(n for n in WITH_JSON if typed[: len(n.split())] == n.split()).replace(" ", ".")
    documents = text.splitlines() if typed[0] == "plan" else [text]
    for document in documents:
        read = json.loads(document, parse_constant=no_constant)
        assert next(iter(read)) == "schema"
        assert read["schema"] == f"avsec.{name}/{SCHEMAS[name]}"
    for path in (out / "evaluation.json", tmp_path / "out.json"):
        if path.is_file():
            assert json.loads(path.read_text())["schema"].startswith(f"avsec.{name}")
    if typed[0] == "run":
        assert run(["report", str(out), "--json", "--pictures", "0"]) == 0
        report = json.loads(capsys.readouterr().out, parse_constant=no_constant)
        assert report["schema"] == f"avsec.report/{SCHEMAS['report']}"
        assert [row["setting"] for row in report["other"]] == [
            "pipeline truth", "pipeline unattacked",
        ]  # fmt: skip
