"""Milliseconds a frame that validators take, and on which part of their work; prints JSON.

    python benchmarks/validation.py [--frames 20]
    python benchmarks/validation.py --page RESULT.json    # what that printed, as a page

Clean frames, and such with a facula on the reference camera: algorithm 2 then asks the next one.
Of a system, besides, to locate and to repair the damage of a camera and of the LiDAR, the attacked
sensor named.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

# Idle threads of the linear algebra would count as work (before NumPy is loaded).
os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import numpy as np

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.sensor_combination import thesis_attack
from avsec_gym.console import progress
from avsec_gym.frame import SensorFrame
from avsec_gym.report.markdown_table import markdown_table
from avsec_gym.rig import camera_rig
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.evidence import evidence_scopes, gather_evidence
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import fitted_on
from avsec_gym.validation.fitting import CleanFrames, fit_threshold_table
from avsec_gym.validation.identification import identify_attacked_sensors
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.likelihood.maximum_likelihood import SCORES, LikelihoodModel
from avsec_gym.validation.recordings import RecordedFrame
from avsec_gym.validation.repair.damaged_scan import damaged_scan
from avsec_gym.validation.repair.localisation import damaged_pixels
from avsec_gym.validation.repair.repair import repair
from avsec_gym.validation.threshold_validator import ThresholdValidator
from avsec_gym.validation.validator import Validation, Validator
from avsec_gym.world.capture import Lidar, render
from avsec_gym.world.layouts import generate_layout
from avsec_gym.world.posed_scenes import posed_scene_of_layout

RIG = camera_rig((0.0, 0.54, -0.27, 0.27, 0.81, 1.08))
"""The rig of chapter 3, and two more cameras to the right, 27 cm from each other."""
SYSTEMS = {
    "LiDAR and 2 cameras": SensorSystem((LIDAR, 3, 2)),
    "LiDAR and 3 cameras": SensorSystem((LIDAR, 1, 3, 2)),
    "LiDAR and 6 cameras": SensorSystem((LIDAR, 5, 4, 1, 3, 0, 2)),
}
PARTS = ("maps, brightness", "scans", "errors", "decision")
DAMAGE = ("located", "repaired")
DEPTH = PairDepth("sgbm")
REFERENCE = 2
BLINDING = Facula(REFERENCE, radius=375.0, strength=1280.0)
"""Five times what saturates the sensor: every triple of the reference contradicts itself."""


def rendered(number: int) -> SensorFrame:
    """What all sensors of the rig see of a layout."""
    posed = posed_scene_of_layout(generate_layout(number), RIG)
    capture = render(posed, cameras=tuple(range(6)), lidar=Lidar())
    assert capture.scan is not None
    return SensorFrame(f"{number:06d}", RIG.calibration, capture.images, capture.scan.points)


def validators(system: SensorSystem, frames: list[SensorFrame]) -> dict[str, Validator]:
    """By method; thresholds beyond which no clean frame lies.

    A likelihood that was never fitted costs as much as one that was.
    """
    named = {frame.id: frame for frame in frames}
    clean = [RecordedFrame(id, partial(named.__getitem__, id)) for id in named]
    table = fit_threshold_table(CleanFrames(clean, system, DEPTH))
    thresholds = ThresholdValidator(table, rate=0.0)
    if len(system) == 3:
        return {"detection": thresholds}
    m = len(evidence_scopes(system))
    model = LikelihoodModel(
        fitted_on(system, DEPTH, RIG.calibration, {}),
        np.full((m, 8, SCORES), -3.0),
        correlation=np.full((2, 2, m, m), 0.8) + 0.2 * np.eye(m),
        lowest=np.full(m, -6.0),
        highest=np.full(m, 6.0),
        weights=np.ones(m + 1),
        clean_scores=np.zeros(1),
        strangest=np.full(1, 1e9),
    )
    return {"algorithm 2": thresholds, "maximum likelihood": LikelihoodValidator(model)}


def parts(validator: Validator, frame: SensorFrame) -> dict[str, float]:
    """Milliseconds of one thread, for a frame without an attack."""
    system = validator.system
    whole = isinstance(validator, LikelihoodValidator)
    last = len(system) - 1
    triples = [triple for triple in system.triples if whole or triple[2] == last]
    pairs = system.pairs() if whole else system.pairs(last)
    between = [pair for pair in pairs if not system.has_scan(pair)]
    errors = DisparityErrors(DisparityMaps(frame, system, DEPTH))
    maps = errors.maps
    found = {
        "maps, brightness": timed(lambda: [maps.view(pair) for pair in between]),
        "scans": timed(lambda: [maps.view(pair) for pair in pairs if pair not in between]),
        "errors": timed(lambda: [errors[triple] for triple in triples]),
    }
    if isinstance(validator, LikelihoodValidator):
        evidence, model = gather_evidence(errors)[None], validator.model
        assert isinstance(model, LikelihoodModel)
        found["decision"] = timed(lambda: model.decode(evidence).statuses())
    elif len(system) > 3:
        found["decision"] = timed(lambda: identify_attacked_sensors(lambda _: False, len(system)))
    return found


def with_reference_attacked(validator: Validator, frames: list[SensorFrame]) -> dict[str, float]:
    """Milliseconds of a frame, and how many cameras' views were looked at."""
    tampered = [BLINDING.attack(frame, seed).frame for seed, frame in enumerate(frames)]
    validations: list[Validation] = []
    whole = [
        timed(lambda frame=frame: validations.append(validator.validate(frame)))
        for frame in tampered
    ]
    views = [{triple[2] for triple in found.errors.known} for found in validations]
    return {"frame": _median(whole), "views": statistics.median(map(len, views))}


def damage(system: SensorSystem, frames: list[SensorFrame]) -> dict[str, dict[str, float]]:
    """Milliseconds to locate the damage of the thesis' attack to a sensor, and to repair it."""
    locating = {
        REFERENCE: lambda frame, trusted: damaged_pixels(frame, REFERENCE, trusted, DEPTH),
        LIDAR: lambda frame, trusted: damaged_scan(frame, trusted, DEPTH),
    }
    found = {}
    for sensor, locate in locating.items():
        attack = thesis_attack([sensor], REFERENCE)
        tampered = [attack.attack(frame, seed).frame for seed, frame in enumerate(frames)]
        trusted = [other for other in system.sensors if other != sensor]
        located = [timed(partial(locate, frame, trusted)) for frame in tampered]
        repaired = [timed(partial(repair, frame, system, [sensor], DEPTH)) for frame in tampered]
        name = "LiDAR" if sensor == LIDAR else "camera"
        found[name] = {"located": _median(located), "repaired": _median(repaired)}
    return found


def timed(work: Callable[[], Any]) -> float:
    begun = time.perf_counter()
    work()
    return 1000 * (time.perf_counter() - begun)


def main() -> None:
    """Render, measure, print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], allow_abbrev=False)
    parser.add_argument("--frames", type=int, default=20, help="to render and to judge")
    parser.add_argument("--page", type=Path, help="print this result as Markdown instead")
    options = parser.parse_args()
    if options.page is not None:
        print("\n".join(page(json.loads(options.page.read_text()))))
        return
    count = options.frames
    frames = []
    with progress("rendering") as shown:
        for number in range(1, count + 1):
            frames.append(rendered(number))
            shown(number, count)
    result: dict[str, Any] = {}
    with progress("systems of sensors") as shown:
        for done, (name, system) in enumerate(SYSTEMS.items(), start=1):
            rows = result[name] = {}
            for method, validator in validators(system, frames).items():
                validator.validate(frames[0])  # compiles, and factorises the covariances
                each = [parts(validator, frame) for frame in frames]
                whole = [timed(partial(validator.validate, frame)) for frame in frames]
                rows[method] = {
                    "frame": _median(whole),
                    "parts": {part: _median([row[part] for row in each]) for part in each[0]},
                    "reference attacked": with_reference_attacked(validator, frames),
                }
            rows["damage"] = damage(system, frames)
            shown(done, len(SYSTEMS))
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    settings = {"depth": DEPTH.settings, "size": [1242, 375], "frames": len(frames)}
    print(json.dumps({"cores": cores, **settings, "milliseconds": result}, indent=1))


def page(result: dict[str, Any]) -> list[str]:
    """Lines of Markdown."""
    shown: list[list[str]] = []
    repaired_rows: list[list[str]] = []
    for system, rows in result["milliseconds"].items():
        for method, row in rows.items():
            if method == "damage":
                for sensor, found in row.items():
                    repaired_rows.append(
                        [system, sensor, *(f"{found[damage]:.0f}" for damage in DAMAGE)]
                    )
                continue
            attacked = row["reference attacked"]
            each = (f"{row['parts'][part]:.1f}" if part in row["parts"] else "–" for part in PARTS)
            views = f"{attacked['frame']:.0f} ({attacked['views']:.0f})"
            shown.append([system, method, f"**{row['frame']:.0f}**", *each, views])
    width, height = result["size"]
    return [
        "# How long validation takes",
        "",
        f"Milliseconds a frame of {width} x {height} pixels, medians of {result['frames']}, depth"
        f" by {result['depth']['name']}, on {result['cores']} cores; made by"
        " `python benchmarks/validation.py`, shown by its `--page`. Parts are measured on one core"
        " each, the frame on all; in brackets: how many cameras' views were looked at where the"
        " reference is attacked.",
        "",
        *markdown_table(["sensors", "method", "frame", *PARTS, "frame, reference attacked"], shown),
        "",
        "## Damage located, and repaired, once the sensor is named",
        "",
        *markdown_table(["sensors", "attacked", *DAMAGE], repaired_rows),
    ]


def _median(values: list[float]) -> float:
    return round(statistics.median(values), 1)


if __name__ == "__main__":
    main()
