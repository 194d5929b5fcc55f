"""Every result belongs to one study, whose commands and sources are there."""

from __future__ import annotations

import json
from collections import Counter

from avsec_gym.closed_loop.error_model.shipped import shipped_error_models
from studies.catalogue import STUDIES, minutes_of_command
from studies.driving_safety.closed_loop import CONTESTED, COUNTERPARTS, MODELLED, RENDERED, SETS
from studies.driving_safety.closed_loop_page import PARTS
from studies.provenance import RECORDS, read_records, sources_of
from studies.source_states import source_state
from studies.study import DATA, RESULTS, ROOT, Step


def test_every_result_belongs_to_one_study() -> None:
    results = {
        file.relative_to(ROOT).as_posix()
        for file in (ROOT / RESULTS).rglob("*")
        if file.is_file() and file != RECORDS
    }
    records = read_records()
    written = Counter(name for study in STUDIES.values() for name in study.writes)
    assert [name for name, count in written.items() if count > 1] == []
    assert set(records) <= set(STUDIES)
    # A study is made with all of its files and its record, or not yet, with none of them.
    made = {name: study for study in records for name in STUDIES[study].writes}
    assert results <= {name for name in made if name.startswith(RESULTS)}
    assert [name for name in written if name not in made and (ROOT / name).exists()] == []
    # What commands write since a study was made is there once it is made anew; pages always are.
    lacking = {name: study for name, study in made.items() if not (ROOT / name).is_file()}
    assert [name for name in lacking if not name.endswith(".json")] == []
    stale = {study: source_state(STUDIES[study], records).stale for study in {*lacking.values()}}
    assert [name for name, study in lacking.items() if not stale[study]] == []


def test_the_runs_of_chapter_5_have_their_pages_as_json_too() -> None:
    for name in ("chapter5_unattacked", "chapter5_without_evidence", "chapter5_without_pyramid"):
        study = STUDIES[name]
        assert study.writes == (f"{RESULTS}/{name}.md", f"{RESULTS}/{name}.json")
        report = study.steps[-1]
        assert report.to == f"{RESULTS}/{name}.json"
        assert "--json" in report.words
        assert f"{RESULTS}/{name}.md" in report.words


def test_measures_are_compared_over_the_joint_patch_too() -> None:
    run = STUDIES["telling_measures"].steps[1].words
    assert {"perturbation", "patch", "joint_patch"} <= set(run)


def test_what_studies_name_is_there() -> None:
    for study in STUDIES.values():
        assert study.steps, study.name
        missing = [name for name in study.sources if not (ROOT / name).exists()]
        assert not missing, f"{study.name}: {missing}"
        assert set(study.shows) <= set(STUDIES), study.name
        # Nothing but what is given, and the folder of runs, is left to be filled in.
        given = {name: ["DIR"] for name in (*DATA, "runs")}
        assert not any("$" in word for step in study.steps for word in step.filled(given))


def test_words_of_a_command() -> None:
    chapter5 = STUDIES["chapter5"]
    assert chapter5.needs == ["kitti", "scenarios"]
    assert chapter5.command == "python -m studies.chapter5 --kitti DIR --scenarios DIR"
    assert [step.to for step in chapter5.steps if step.to] == [
        f"{RESULTS}/chapter5.json", f"{RESULTS}/chapter5_manifest.json"
    ]  # fmt: skip
    run = chapter5.steps[1]
    assert run.words[:5] == ("-m", "avsec_gym", "run", "chapter5", "--scenarios")
    assert "frames=r/twins/street,r/twins/highway" in run.filled(
        {"scenarios": ["s"], "runs": ["r"]}
    )
    facula = '{"name": "facula", "camera": 3}'
    assert any(facula in step.words for step in STUDIES["pictures"].steps)


def test_the_study_of_the_closed_loop_drives_all_its_sets_by_every_shipped_model() -> None:
    parts = [STUDIES[name] for name in PARTS]
    assert STUDIES["closed_loop"].shows == PARTS
    drives = [step for part in parts for step in part.steps if "drive" in step.words]
    folders = [step.words[step.words.index("--out") + 1] for step in drives]
    scenes, on_sensors = (f"$runs/{name}" for name in PARTS)
    assert folders == [
        *(f"{scenes}/{name}" for name in MODELLED),
        *(f"{on_sensors}/{name}" for name in ("rendered", "rendered_pgd", "models")),
    ]
    assert [folder.rpartition("/")[2] for folder in folders] == list(SETS)
    *by_error_models, rendered, under_gradients, models = drives
    for step in (*by_error_models, models):
        assert set(shipped_error_models()) <= set(step.words)
    assert {"detector", "attacked", "defended"} <= set(rendered.words)
    settings = [
        [json.loads(word)["name"] for word in step.words if word.startswith('{"name": "')]
        for step in (rendered, under_gradients, models)
    ]
    assert {"defended_unattacked", "attacked_patch", "defended_patch"} <= set(settings[0])
    assert settings[1] == ["attacked_thesis_pgd", "defended_thesis_pgd"]
    # Every model drives beside what it is a model of, which is rendered once.
    for model in shipped_error_models():
        set_name, setting = COUNTERPARTS.get(model, ("models", f"{RENDERED}{model}"))
        step = {"rendered": rendered, "rendered_pgd": under_gradients, "models": models}[set_name]
        assert setting in step.words or any(f'"name": "{setting}"' in word for word in step.words)
    assert len(settings[2]) == len(shipped_error_models()) - len(COUNTERPARTS)
    # A study that was stopped goes on.
    assert all("--resume" in step.words for step in drives)
    # What is rendered is contested, the same drives in all three.
    (looked,) = [step for part in parts for step in part.steps if "find" in step.words]
    assert looked.words[-1].endswith(f"/{CONTESTED}")
    assert all(looked.words[-1] in step.words for step in (rendered, under_gradients, models))
    assert "docs/images/closed_loop.gif" in parts[1].writes
    given = {"tracking": ["/data/tracking"], "runs": ["runs"]}
    [place] = [word for word in drives[2].filled(given) if word.startswith("{")]
    assert json.loads(place) == {"source": "kitti_tracking", "root": "/data/tracking"}
    assert [part.needs for part in parts] == [["scenarios", "tracking"], []]
    # No rendered car is of a design that detectors learned from, as of the error models' drives.
    named = [step.words[step.words.index("--scenarios") + 1] for step in by_error_models]
    procedural = [json.loads(word) for word in named if '"drives"' in word]
    assert [each["assets"] for each in procedural] == ["judge"]
    assert "drives" not in named


def test_minutes_of_a_command_are_those_of_the_parts_that_it_makes_too() -> None:
    detectors = STUDIES["detectors"]
    # Need no data.
    made = (
        "detector_precision",
        "decoding_rules",
        "detector_benchmark",
        "detector_ranking",
        "contested_ranking",
        "training_history",
    )
    parts = sum(STUDIES[name].minutes for name in made)
    assert minutes_of_command(detectors) == detectors.minutes + parts
    assert all(
        minutes_of_command(study) == study.minutes for study in STUDIES.values() if not study.shows
    )


def test_a_name_alone_stands_for_all_that_is_given() -> None:
    step = Step(("a.py", "--world", "$classifiers", "--out", "$runs/a"))
    given = {"classifiers": ["one", "two"], "runs": ["runs"]}
    assert list(step.filled(given)) == ["a.py", "--world", "one", "two", "--out", "runs/a"]


def test_sources_reach_the_experiment_its_detectors_and_their_weights() -> None:
    found = set(sources_of(STUDIES["believed"].sources).values())
    assert {
        "avsec_gym/boxes.py",
        "avsec_gym/perception/detectors/pixor/network.py",
        "avsec_gym/perception/weights/pixor_small.safetensors",
        "avsec_gym/attacks/lidar_spoofing.py",
        "avsec_gym/experiments/chapter3/objects/believed_rates.py",
    } <= found
    assert not any("dsgn_small" in name or name.startswith("studies/") for name in found)


def test_a_study_of_commands_has_their_sources() -> None:
    """Without any it could never become stale."""
    assert all(study.sources for study in STUDIES.values())
    found = set(sources_of(STUDIES["world_pictures"].sources).values())
    assert {
        "avsec_gym/commands/world_pictures.py",
        "avsec_gym/drawing/frame_picture.py",
        "avsec_gym/world/capture.py",
    } <= found
