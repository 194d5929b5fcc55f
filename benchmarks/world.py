"""What a rendered frame costs: seconds of one core, memory, frames a second; prints JSON.

python benchmarks/world.py [--frames 8]
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

# One core: idle threads of the linear algebra would count as work (before NumPy is loaded).
os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import cv2
import numpy as np

from avsec_gym.rig import resized_rig
from avsec_gym.world.capture import Lidar, Renderer, Sweep, render, renderer_of, scan_of
from avsec_gym.world.export import make_data_set, suite_recipe
from avsec_gym.world.layouts import generate_layout
from avsec_gym.world.motion import with_ego_speed
from avsec_gym.world.posed_scenes import PosedScene, posed_scene_of_layout

DETECTOR_WIDTHS = (768, 640)
"""Columns that DSGN small and Stereo R-CNN small read; `avsec world make --width` renders so."""


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds of processor time, of all threads together, and what came out."""
    begun = time.process_time()
    result = work()
    return time.process_time() - begun, result


def one_core(frames: int) -> dict[str, float]:
    """Medians over frames of the default suite, textures and kernels cached."""
    render(posed_scene_of_layout(generate_layout(0)))
    rows: dict[str, list[float]] = {}
    for number in range(1, frames + 1):
        build, (posed, renderer) = timed(lambda number=number: standing(number))
        posed = with_ego_speed(posed, 10.0)
        look = partial(render, posed, renderer=renderer, lidar=None)
        still, rolling = (
            partial(scan_of, posed, 0, Lidar(), sweep, renderer)
            for sweep in (Sweep.INSTANT, Sweep.ROLLING)
        )
        pair, _ = timed(lambda look=look: look(cameras=(2, 3)))
        narrow = {
            f"stereo_pair_with_labels_{width}_wide": partial(
                render,
                replace(posed, rig=resized_rig(posed.rig, width)),
                renderer=renderer,
                lidar=None,
                cameras=(2, 3),
            )
            for width in DETECTOR_WIDTHS
        }
        measured = {
            "scene": build,
            "labels_and_depth": timed(lambda look=look: look(cameras=()))[0],
            "one_camera_with_labels": timed(lambda look=look: look(cameras=(2,)))[0],
            "stereo_pair_with_labels": pair,
            "scene_and_stereo_pair_with_labels": build + pair,
            "scan": timed(still)[0],
            "rolling_scan": timed(rolling)[0],
        } | {name: timed(look)[0] for name, look in narrow.items()}
        for name, seconds in measured.items():
            rows.setdefault(name, []).append(seconds)
    return {name: round(statistics.median(values), 3) for name, values in rows.items()}


def standing(number: int) -> tuple[PosedScene, Renderer]:
    """A layout's place drawn and built up, all meshes made, embree's hierarchy built."""
    posed = posed_scene_of_layout(generate_layout(number))
    renderer = renderer_of(posed)
    renderer.scene.blocked(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))
    return posed, renderer


def frames_per_second(frames: int, workers: int) -> float:
    """Of `avsec world make`, files written; the start of the workers included."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        make_data_set(suite_recipe("mixed", frames), Path(folder) / "suite", workers=workers)
        return round(frames / (time.perf_counter() - begun), 3)


def peak_memory(who: int) -> float:
    """Gigabytes."""
    unit = 1 if sys.platform == "darwin" else 1024
    return round(resource.getrusage(who).ru_maxrss * unit / 1e9, 2)


def main() -> None:
    """Measure, print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=8)
    options = parser.parse_args()
    cv2.setNumThreads(1)
    result = {
        "frames": options.frames,
        "cores": os.cpu_count(),
        "seconds_of_one_core_median": one_core(options.frames),
        "peak_memory_gb": peak_memory(resource.RUSAGE_SELF),
        "frames_per_second_by_workers": {
            str(workers): frames_per_second(2 * options.frames, workers) for workers in (1, 2)
        },
        "peak_memory_of_a_worker_gb": peak_memory(resource.RUSAGE_CHILDREN),
    }
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
