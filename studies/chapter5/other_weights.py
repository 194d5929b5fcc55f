"""Makes the networks whose parts were left out, to see what these parts are good for.

``without_evidence``: Stereo R-CNN whose scores are of the class alone, as published, instead of the
images' agreement too.  ``without_pyramid``: DSGN without its spatial pyramid pooling; the package's
weights go on learning without it, and a patch is trained against them as the package's were.  Both
are calibrated on the frames that the package's own were (docs/detectors.md, "Training").

    python -m studies.chapter5.other_weights without_evidence --runs runs
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from avsec_gym.cli import run as avsec
from avsec_gym.errors import AvsecError
from studies.answer import exit_code

_WEIGHTS = Path("avsec_gym/perception/weights")
_PATCHES = Path("avsec_gym/attacks/patches")


def without_evidence(runs: Path) -> None:
    """Writes without_evidence/stereo_rcnn_small.safetensors below the runs, once."""
    validation, done = _frames(runs, "validation", 200, 3), runs / "without_evidence"
    if done.is_dir():
        return
    part = done.with_suffix(".part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    for file in _WEIGHTS.glob("stereo_rcnn_small.*"):
        shutil.copy(file, part)
    weights = part / "stereo_rcnn_small.safetensors"
    _avsec("weights", "calibrate", weights, "--kitti", validation, "--no-evidence")
    part.rename(done)


def without_pyramid(runs: Path) -> None:
    """Writes dsgn_without_pyramid/weights.safetensors below the runs, once, and all patches."""
    validation, frames = _frames(runs, "validation", 200, 3), _frames(runs, "world", 500, 1)
    done = runs / "dsgn_without_pyramid"
    weights, part = done / "weights.safetensors", done.with_suffix(".part")
    if not weights.is_file():
        start = _WEIGHTS / "dsgn_small.safetensors"
        _avsec(
            *("train", "dsgn", "--preset", "small_without_pyramid", "--start", start),
            *("--data", frames, "--out", part, "--batch", 2, "--threads", 1, "--epochs", 3),
            *("--learning-rate", "5e-4", "--keep", "last", "--resume"),
        )
        _avsec("weights", "calibrate", part / "weights.safetensors", "--kitti", validation)
        part.rename(done)
    victim = {"name": "dsgn", "configuration": "small_without_pyramid", "weights": str(weights)}
    trained = runs / "patch_without_pyramid"
    _avsec(
        *("attack", "patch", "--detector", json.dumps(victim), "--kitti", frames, "--limit", 80),
        *("--epochs", 6, "--threads", 1, "--out", trained, "--resume"),
    )
    patches = shutil.copytree(_PATCHES, runs / "patches", dirs_exist_ok=True)
    shutil.copy(trained / "patch.safetensors", patches / "dsgn_without_pyramid.safetensors")


def _frames(runs: Path, name: str, frames: int, seed: int) -> Path:
    """Frames of the procedural world, made or there."""
    out = runs / "train" / name
    _avsec(
        *("world", "make", "--suite", "mixed", "--frames", frames, "--seed", seed),
        *("--no-lidar", "--out", out),
    )
    return out


def _avsec(*words: str | int | Path) -> None:
    if code := avsec([str(word) for word in words]):
        raise AvsecError(f"avsec {words[0]} {words[1]} ended with {code}.")


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("what", choices=("without_evidence", "without_pyramid"))
    parser.add_argument("--runs", type=Path, default=Path("runs"))
    options = parser.parse_args(arguments)
    make = without_evidence if options.what == "without_evidence" else without_pyramid
    return exit_code(lambda: make(options.runs))


if __name__ == "__main__":
    sys.exit(main())
