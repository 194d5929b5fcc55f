"""The kinds of files that users give: a sound one, how it is read, what it can never hold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import connected_files
import driving_files
import impossible
import sound_files
import tiny_run
import world_files
from mutate_bytes import BYTES, Mutator
from mutate_containers import CHECKPOINT, NPZ, PNG, SAFETENSORS, SQLITE
from mutate_other_trees import JSON_LINES, YAML
from mutate_text import TEXT
from mutate_trees import JSON, XML


@dataclass(frozen=True)
class Kind:
    """A kind of file.

    Args:
        name: Such as ``label``.
        file: Which file of the folder that `make` fills is damaged.
        make: Fills an empty folder with sound files.
        read: Reads the folder as a command does; returns what it read.
        mutators: Of this kind, beside those of replaced files.
        impossible: States what is wrong with something that was read, None if nothing is.
    """

    name: str
    file: str
    make: Callable[[Path], object]
    read: Callable[[Path], Any]
    mutators: dict[str, Mutator]
    impossible: Callable[[Any], str | None] = impossible.nothing


def _text(text: str, name: str) -> Callable[[Path], object]:
    def make(folder: Path) -> None:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)

    return make


def _at(make: Callable[[Path], object], name: str) -> Callable[[Path], object]:
    def make_there(folder: Path) -> None:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        make(folder / name)

    return make_there


def _label(folder: Path) -> Any:
    from avsec_gym.kitti.labels import read_labels

    return read_labels(folder / "000000.txt", keep_dont_care=True)


def _detections(folder: Path) -> Any:
    from avsec_gym.kitti.detections import DetectionFolder

    return DetectionFolder(folder).read()[0]


def _calibration(folder: Path) -> Any:
    from avsec_gym.kitti.calibration import read_calibration

    return read_calibration(folder / "000000.txt")


def _raw_calibration(folder: Path) -> Any:
    from avsec_gym.kitti.raw_calibration import read_raw_calibration

    return read_raw_calibration(folder)


def _tracks(folder: Path) -> Any:
    from avsec_gym.kitti.tracking import read_tracking_labels

    return read_tracking_labels(folder / "0000.txt", keep_dont_care=True)


def _split(folder: Path) -> Any:
    from avsec_gym.kitti.splits import read_split

    return read_split(folder / "val.txt")


def _label_list(folder: Path) -> Any:
    from avsec_gym.scenario.label_list import read_label_list

    return read_label_list(folder / "train.txt")


def _flags(folder: Path) -> Any:
    from avsec_gym.kitti.labels import parse_labels
    from avsec_gym.scenario.moving_flags import flagged

    labels = parse_labels(sound_files.LABELS, folder / "000000.txt")
    return flagged(labels, folder / "flags.txt")[0]


def _timestamps(folder: Path) -> Any:
    from avsec_gym.kitti.timestamps import read_timestamps

    return read_timestamps(folder / "timestamps.txt")


def _oxts(folder: Path) -> Any:
    from avsec_gym.kitti.oxts import read_oxts
    from avsec_gym.kitti.oxts_poses import poses_from_oxts

    oxts = read_oxts(sorted(folder.glob("*.txt")))
    return oxts, poses_from_oxts(oxts)


def _oxts_table(folder: Path) -> Any:
    from avsec_gym.kitti.oxts import read_oxts_table
    from avsec_gym.kitti.oxts_poses import poses_from_oxts

    oxts = read_oxts_table(folder / "0000.txt")
    return oxts, poses_from_oxts(oxts)


def _odometry_calibration(folder: Path) -> Any:
    from avsec_gym.kitti.calibration import read_odometry_calibration

    return read_odometry_calibration(folder / "calib.txt")


def _odometry_poses(folder: Path) -> Any:
    from avsec_gym.kitti.number_tables import read_numbers

    return read_numbers(folder / "00.txt", 12)


def _hub_weights(folder: Path) -> Any:
    """Imported beside it; an import that is refused leaves nothing."""
    from avsec_gym.errors import DataError
    from avsec_gym.hub.detectors import import_weights
    from avsec_gym.perception.weights.store import read_weights

    out = folder / "imported.safetensors"
    for left in folder.glob("imported*"):
        left.unlink()
    try:
        import_weights(folder, out)
    except DataError:
        assert not out.exists(), "a refused import left its weights"
        raise
    return read_weights(out)[0]


def _tracklets(folder: Path) -> Any:
    from avsec_gym.kitti.tracklets import read_tracklets

    return read_tracklets(folder / "tracklet_labels.xml")


def _image(folder: Path) -> Any:
    from avsec_gym.kitti.sensor_files import read_image

    return read_image(folder / "000000.png")


def _scan(folder: Path) -> Any:
    from avsec_gym.kitti.sensor_files import read_points

    return read_points(folder / "000000.bin")


def _disparity(folder: Path) -> Any:
    from avsec_gym.kitti.map_files import read_disparity

    return read_disparity(folder / "000000.png")


def _primitives(folder: Path) -> Any:
    from avsec_gym.planners.primitive_files import read_primitives

    return read_primitives(folder / "set.xml")


def _commonroad(folder: Path) -> Any:
    """As `avsec plan` does: read, and planned; and how many obstacles the file seems to hold."""
    from xml.etree import ElementTree

    from avsec_gym.errors import DataError, PlanningError
    from avsec_gym.planners.planner import MotionPrimitivePlanner
    from avsec_gym.scenario.commonroad import read_commonroad

    path = folder / "scenario.xml"
    scenario = read_commonroad(path)
    try:
        MotionPrimitivePlanner(node_limit=2_000).plan(scenario)
    except PlanningError as error:
        raise DataError(str(error), path=path) from None
    root = ElementTree.fromstring(path.read_text())
    return scenario, sum(each.find("shape") is not None for each in root.iter())


def _patch(folder: Path) -> Any:
    from avsec_gym.attacks.patch_files import load_patch

    return load_patch(folder / "patch.safetensors")


def _object_scan(folder: Path) -> Any:
    from avsec_gym.attacks.object_scan import read_object_scan

    return read_object_scan(folder / "car.npz")


def _weights(folder: Path) -> Any:
    from avsec_gym.perception.weights.store import load_weights

    network: Any = sound_files.network()
    return load_weights(folder / "tiny.safetensors", network), network.state_dict()


def _published(folder: Path) -> Any:
    from avsec_gym.perception.weights.published import load_published

    network: Any = sound_files.network()
    load_published(folder / "tiny.pth", network)
    return network.state_dict()


def _training(folder: Path) -> Any:
    """As `avsec train --resume` does: the network and the optimizer go on from it."""
    import torch

    from avsec_gym.perception.training.checkpoint import (
        resume_network,
        resume_optimizer,
        start_or_resume,
    )

    state = start_or_resume(folder, {"seed": 0}, resume=True)
    if not state.trained:
        return state, {}
    network: Any = sound_files.network()
    optimizer = torch.optim.AdamW(network.parameters())
    average = resume_network(state, network, folder)
    resume_optimizer(state, optimizer, folder)
    sum(value.sum() for value in network.parameters()).backward()
    optimizer.step()
    return average


def _curves(folder: Path) -> Any:
    from avsec_gym.perception.training.curves import read_curves

    return read_curves(folder)


def _thresholds(folder: Path) -> Any:
    from avsec_gym.validation.thresholds import read_threshold_table

    table = read_threshold_table(folder / "thresholds.json")
    table.thresholds(0.01)
    return table


def _likelihood(folder: Path) -> Any:
    import numpy as np

    from avsec_gym.validation.evidence.evidence import evidence_scopes
    from avsec_gym.validation.likelihood.maximum_likelihood import read_likelihood_model

    model = read_likelihood_model(folder / "likelihood.json")
    model.decode(np.full((2, len(evidence_scopes(model.on.system))), 0.1))
    return model


def _validation_rows(folder: Path) -> Any:
    from avsec_gym.commands.validation_line import validation_line
    from avsec_gym.validation.validation_folder import ValidationFolder, summary

    # As `avsec validate` does, which goes on with them: every line, and their sum.
    rows = ValidationFolder(folder, sound_files.VALIDATION).rows
    return [validation_line(row) for row in rows.values()], summary(rows)


def _make_validation_rows(folder: Path) -> None:
    from avsec_gym.validation.validation_folder import ValidationFolder

    results = ValidationFolder(folder, sound_files.VALIDATION)
    for row in sound_files.validation_rows():
        results.add(row)


def _samples(folder: Path) -> Any:
    """As a fit that was stopped and goes on does: of frames that are all measured."""
    from avsec_gym.sensor_system import SensorSystem
    from avsec_gym.storage.json_lines import JsonLines
    from avsec_gym.validation.fitting import KeptSample, check_samples

    path = folder / "samples.jsonl"
    rows = JsonLines(path, KeptSample).rows
    check_samples(rows, (len(SensorSystem(("lidar", 3, 2)).triples), 4), path)
    return rows


def _object_root(folder: Path) -> Any:
    from avsec_gym.kitti.check import check_data
    from avsec_gym.kitti.dataset import KittiObject

    check_data(folder, deep=True)
    data = KittiObject(folder)
    return [(data.labels(id), data.calibration(id)) for id in data.ids()]


def _data_set(folder: Path) -> Any:
    from avsec_gym.world.export.manifest import (
        changed_files,
        check_same,
        new_manifest,
        read_manifest,
    )

    changed = changed_files(folder, full=True)
    manifest = read_manifest(folder)
    assert manifest is not None, "`changed_files` refuses a folder without one"
    check_same(folder, manifest, new_manifest(sound_files.WORLD_SETTINGS))
    return changed


def _make_object_root(folder: Path) -> None:
    training = folder / "training"
    for part, make in (
        ("label_2", _text(sound_files.LABELS, "000000.txt")),
        ("calib", _text(sound_files.CALIBRATION, "000000.txt")),
        ("image_2", _at(sound_files.image, "000000.png")),
        ("image_3", _at(sound_files.image, "000000.png")),
        ("velodyne", _at(sound_files.scan, "000000.bin")),
    ):
        (training / part).mkdir(parents=True)
        make(training / part)
    _text("000000\n", "val.txt")(folder / "ImageSets")


ROWS = "training/label_2/000000.txt"
_LINES = BYTES | TEXT
KINDS = {
    kind.name: kind
    for kind in (
        Kind("label", "000000.txt", _text(sound_files.LABELS, "000000.txt"), _label, _LINES,
             impossible.boxes),
        Kind("detections", "000000.txt", _text(sound_files.DETECTIONS, "000000.txt"), _detections,
             _LINES, impossible.detections),
        Kind("calibration", "000000.txt", _text(sound_files.CALIBRATION, "000000.txt"),
             _calibration, _LINES, impossible.calibration),
        Kind("raw calibration", "calib_cam_to_cam.txt", sound_files.raw_calibration,
             _raw_calibration, _LINES, impossible.calibration),
        Kind("tracking labels", "0000.txt", _text(sound_files.TRACKS, "0000.txt"), _tracks, _LINES,
             impossible.boxes),
        Kind("split", "val.txt", _text("000000\n000003\n000107\n", "val.txt"), _split, _LINES),
        Kind("label list", "train.txt", _at(sound_files.label_list, "train.txt"), _label_list,
             _LINES, impossible.finite),
        Kind("moving flags", "flags.txt", _text("0\n1\n-1\n", "flags.txt"), _flags, _LINES,
             impossible.boxes),
        Kind("timestamps", "timestamps.txt", _at(sound_files.timestamps, "timestamps.txt"),
             _timestamps, _LINES),
        Kind("oxts", "0000000001.txt", sound_files.oxts, _oxts, _LINES, impossible.finite),
        Kind("oxts table", "0000.txt", sound_files.oxts_table, _oxts_table, _LINES,
             impossible.finite),
        Kind("odometry calibration", "calib.txt",
             _text(sound_files.ODOMETRY_CALIBRATION, "calib.txt"), _odometry_calibration, _LINES,
             impossible.calibration),
        Kind("odometry poses", "00.txt", _text(3 * "1 0 0 0 0 1 0 0 0 0 1 0.5\n", "00.txt"),
             _odometry_poses, _LINES, impossible.finite),
        Kind("hub weights", "model.safetensors", sound_files.hub_weights, _hub_weights,
             BYTES | SAFETENSORS, impossible.finite),
        Kind("hub card", "config.json", sound_files.hub_weights, _hub_weights, _LINES | JSON),
        Kind("tracklets", "tracklet_labels.xml", _at(sound_files.tracklets, "tracklet_labels.xml"),
             _tracklets, _LINES | XML, impossible.finite),
        Kind("image", "000000.png", _at(sound_files.image, "000000.png"), _image, BYTES | PNG),
        Kind("disparity", "000000.png", _at(sound_files.disparity, "000000.png"), _disparity,
             BYTES | PNG, impossible.disparity),
        Kind("scan", "000000.bin", _at(sound_files.scan, "000000.bin"), _scan, BYTES,
             impossible.scan),
        Kind("data set", ROWS, _make_object_root, _object_root, _LINES),
        Kind("commonroad", "scenario.xml", _at(sound_files.commonroad, "scenario.xml"),
             _commonroad, _LINES | XML, impossible.problem_of_file),
        Kind("primitives", "set.xml", _at(sound_files.primitives, "set.xml"), _primitives,
             _LINES | XML, impossible.primitives),
        Kind("world manifest", "manifest.json", sound_files.data_set, _data_set, _LINES | JSON),
        Kind("run results", "results.sqlite", sound_files.run, tiny_run.look, BYTES | SQLITE),
        Kind("run manifest", "manifest.json", sound_files.run, tiny_run.look, _LINES | JSON),
        Kind("validation record", "validation.json", _make_validation_rows, _validation_rows,
             _LINES | JSON),
        Kind("validation rows", "frames.jsonl", _make_validation_rows, _validation_rows,
             _LINES | JSON_LINES, impossible.finite),
        Kind("fit samples", "samples.jsonl", _at(sound_files.samples, "samples.jsonl"), _samples,
             _LINES | JSON_LINES, impossible.finite),
        Kind("thresholds", "thresholds.json", _at(sound_files.thresholds, "thresholds.json"),
             _thresholds, _LINES | JSON, impossible.shares),
        Kind("likelihood", "likelihood.json", _at(sound_files.likelihood, "likelihood.json"),
             _likelihood, _LINES | JSON, impossible.finite),
        Kind("weights", "tiny.safetensors", _at(sound_files.weights, "tiny.safetensors"), _weights,
             BYTES | SAFETENSORS, impossible.finite),
        Kind("weights card", "tiny.json", _at(sound_files.weights, "tiny.safetensors"), _weights,
             _LINES | JSON),
        Kind("published weights", "tiny.pth", _at(sound_files.published, "tiny.pth"), _published,
             BYTES | CHECKPOINT, impossible.finite),
        Kind("training checkpoint", "checkpoint.pt", sound_files.training, _training,
             BYTES | CHECKPOINT, impossible.finite),
        Kind("training curves", "curves.jsonl", _at(sound_files.json_lines, "curves.jsonl"),
             _curves, _LINES | JSON_LINES),
        Kind("patch", "patch.safetensors", _at(sound_files.patch, "patch.safetensors"), _patch,
             BYTES | SAFETENSORS, impossible.finite),
        Kind("patch card", "patch.json", _at(sound_files.patch, "patch.safetensors"), _patch,
             _LINES | JSON),
        Kind("error model", "dsgn.json", _at(connected_files.error_model, "dsgn.json"),
             connected_files.read_error_model, _LINES | JSON, impossible.finite),
        Kind("connected fit", "fit.json", _at(connected_files.connected_fit, "fit.json"),
             connected_files.read_connected_fit, _LINES | JSON, impossible.finite),
        Kind("learned fit", "learned.json", _at(connected_files.learned_fit, "learned.json"),
             connected_files.read_learned_fit, _LINES | JSON, impossible.finite),
        Kind("region message", connected_files.MESSAGE, connected_files.region_message,
             connected_files.read_region_message, BYTES, impossible.finite),
        Kind("crop message", connected_files.MESSAGE, connected_files.crop_message,
             connected_files.read_crop_message, BYTES, impossible.finite),
        Kind("claim message", connected_files.MESSAGE, connected_files.claim_message,
             connected_files.read_claim_message, BYTES, impossible.finite),
        Kind("count message", connected_files.MESSAGE, connected_files.count_message,
             connected_files.read_count_message, BYTES, impossible.finite),
        Kind("opv2v annotations", f"{connected_files.SCENARIO}.yaml", connected_files.opv2v,
             connected_files.read_opv2v, _LINES | YAML, impossible.finite),
        Kind("opv2v points", f"{connected_files.SCENARIO}.pcd", connected_files.opv2v,
             connected_files.read_opv2v, _LINES, impossible.finite),
        Kind("opv2v binary points", f"{connected_files.SCENARIO}.pcd",
             connected_files.opv2v_binary, connected_files.read_opv2v, BYTES, impossible.finite),
        Kind("object scan", "car.npz", _at(sound_files.object_scan, "car.npz"), _object_scan,
             BYTES | NPZ, impossible.finite),
        Kind("scene file", f"training/scene/{world_files.FRAME}.json", world_files.labelled_scene,
             world_files.read_labelled_scene, _LINES | JSON, impossible.finite),
        Kind("vehicle's scene file", f"vehicle_0/training/scene/{world_files.FRAME}.json",
             world_files.instant, world_files.read_instant, _LINES | JSON, impossible.finite),
        Kind("instant", f"objects/{world_files.FRAME}.json", world_files.instant,
             world_files.read_instant, _LINES | JSON, impossible.finite),
        Kind("pose", "pose.txt", world_files.pose, world_files.read_pose, _LINES,
             impossible.finite),
        Kind("driven commonroad", "scenario.xml", world_files.commonroad_folder,
             world_files.drive_with, _LINES | XML, impossible.finite),
        Kind("drive record", "drives.json", driving_files.drives, driving_files.read_drives,
             _LINES | JSON),
        Kind("drive rows", "drives.jsonl", driving_files.drives, driving_files.read_drives,
             _LINES | JSON_LINES),
        Kind("drive seconds", "seconds.jsonl", driving_files.drives, driving_files.read_drives,
             _LINES | JSON_LINES),
        Kind("drive film", "films/truth_a_left.npz", driving_files.drives,
             driving_files.read_drives, BYTES | NPZ, impossible.finite),
        Kind("benchmark's labels", "kitti_1.json",
             _at(driving_files.frozen_labels, "kitti_1.json"), driving_files.read_frozen_labels,
             _LINES | JSON),
        Kind("agent configuration", "sac.yml", driving_files.agent_configuration,
             driving_files.read_agent_configuration, _LINES | YAML),
        Kind("agent settings", "agent/config.yml", driving_files.agent, driving_files.read_agent,
             _LINES | YAML),
        Kind("agent card", "agent/card.json", driving_files.agent, driving_files.read_agent,
             _LINES | JSON),
        Kind("agent weights", "agent/weights.safetensors", driving_files.agent,
             driving_files.read_agent, BYTES | SAFETENSORS, impossible.finite),
        Kind("agent checkpoint", "agent/checkpoint.safetensors", driving_files.agent,
             driving_files.read_training, BYTES | SAFETENSORS),
    )
}  # fmt: skip
