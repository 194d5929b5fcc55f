"""The look through KITTI's stereo benchmarks of 2012 and 2015."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from avsec_gym.kitti.check_object import look_at_image
from avsec_gym.kitti.layouts import stereo_folders
from avsec_gym.kitti.map_files import read_disparity
from avsec_gym.kitti.report import Files, Sizes, Survey
from avsec_gym.kitti.stereo import pair_ids, stereo_layout
from avsec_gym.storage.regular_files import is_folder


def check_stereo(survey: Survey, *, deep: bool) -> None:
    """Look at the first pair of each scene, and at its true disparities."""
    for half in stereo_folders(survey.root):
        layout = stereo_layout(half)
        assert layout is not None, "these folders have one"
        survey.notes.append(f"{survey.name(half)} is of KITTI {layout.name}.")
        ids = {name: pair_ids(half / name) for name in layout.folders if is_folder(half / name)}
        survey.look_at(
            [
                Files(
                    half / name,
                    [half / name / f"{id}.png" for id in there],
                    _look_at_truth if name in layout.truth.values() else look_at_image(deep),
                )
                for name, there in ids.items()
            ]
        )
        label = f"{half.name}/" if half != survey.root else ""
        testing = half.name == "testing"  # KITTI keeps its truth to itself.
        expected = (layout.left, layout.right, *(() if testing else (layout.truth["occ"],)))
        survey.notes += [f"There is no folder {label}{n}." for n in expected if n not in ids]
        for lacks in expected[1:]:
            survey.compare(
                f"{label}{layout.left}",
                ids.get(layout.left, ()),
                f"{label}{lacks}",
                ids.get(lacks, ()),
            )
        survey.compare_sizes(half / layout.left, half / layout.right)


def _look_at_truth(path: Path, _: Counter[str], __: Sizes) -> None:
    read_disparity(path)
