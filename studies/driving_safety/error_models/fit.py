"""Fits the error models that the package ships, and holds them against other drives.

Run ``python -m studies.driving_safety.error_models.fit --runs DIR --json FILE`` after `detect`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from avsec_gym.closed_loop.error_model.check import check_error_model
from avsec_gym.closed_loop.error_model.fit import DetectedFrame, fit_error_model
from avsec_gym.closed_loop.error_model.model import write_error_model
from avsec_gym.closed_loop.error_model.shipped import SHIPPED_MODELS
from avsec_gym.closed_loop.error_model.stored_frames import stored_frames
from avsec_gym.perception.weights.weights_file import weights_file_hash
from studies.answer import answer
from studies.driving_safety.error_models.cases import CHECK, FIT, Case, cases

SCORE_THRESHOLD = 0.3
"""Detections of a lower score are not planned on, as in the pipeline."""


def fitted(runs: Path, out: Path) -> dict[str, Any]:
    """Fit and check the error model of every case, and write it.

    Args:
        runs: The folder of the study.
        out: Folder of the error models, which are written over.

    Raises:
        DataError: Drives or detections are missing.
    """
    return {"models": [_fitted(case, runs, out) for case in cases()]}


def _fitted(case: Case, runs: Path, out: Path) -> dict[str, Any]:
    card = {
        "detector": case.detector,
        "weights": weights_file_hash(case.detector),
        "attack": case.arguments or "",
        "score_threshold": SCORE_THRESHOLD,
    }
    model = fit_error_model(_frames(case, runs, FIT), card)
    others = _frames(case, runs, CHECK)
    rows = [{**asdict(each), "answer": each.answer} for each in check_error_model(model, others)]
    drives = len({frame.drive for frame in others})
    model = replace(model, card={**model.card, "check": rows, "check_drives": drives})
    out.mkdir(parents=True, exist_ok=True)
    write_error_model(out / f"{case.name}.json", model, overwrite=True)
    return {"name": case.name, **model.card}


def _frames(case: Case, runs: Path, of: str) -> list[DetectedFrame]:
    return [
        frame
        for kitti, detections in case.folders(runs, of)
        for frame in stored_frames(
            kitti, detections, limit=len(case.ids(kitti)), score_threshold=SCORE_THRESHOLD
        )
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--runs", type=Path, required=True, help="folder of the study")
    parser.add_argument("--out", type=Path, default=SHIPPED_MODELS, help="of the error models")
    parser.add_argument("--json", type=Path, help="the result; default: standard output")
    options = parser.parse_args(arguments)
    return answer(options, lambda asked: fitted(asked.runs, asked.out))


if __name__ == "__main__":
    sys.exit(main())
