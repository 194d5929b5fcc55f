"""How well damage is located and repaired: figures, and a picture of each attack.

Run ``python -m avsec_gym.experiments.chapter3.localisation --frames 6 --out runs/localisation``:
on frames of the procedural world; with ``--kitti-raw DRIVE`` or ``--kitti ROOT --frame 000107``
on others.  The true area judges; what is located knows nothing of it.
"""

from __future__ import annotations

import argparse
import json
import logging
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import OpticalAttack, TamperedFrame
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import AvsecError
from avsec_gym.experiments.chapter3.localisation_figure import draw_repair
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.raw import Drive
from avsec_gym.kitti.text_files import write_text
from avsec_gym.perception.detectors import Detector, make_detector
from avsec_gym.report.scenario_picture import save_picture
from avsec_gym.sensor_system import KITTI_SYSTEM, SensorSystem
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.moments import Moment
from avsec_gym.validation.repair import Repair, repair
from avsec_gym.world.export import world_drives

_LOG = logging.getLogger(__name__)
RADII = (37.5, 112.5, 225.0, 375.0)
"""Of faculae, pixels."""
WIDTHS = (0.5, 1.5, 2.5)
"""Of bogus returns, metres."""
_FOUND = 0.5
"""Overlap of two 2D boxes of one object."""


@dataclass(frozen=True)
class Overlap:
    """A found area beside the true one; None where it is a share of nothing.

    Args:
        iou: Intersection over union.
        precision: Share of the found area that is true.
        recall: Share of the true area that is found.
    """

    iou: float | None
    precision: float | None
    recall: float | None


@dataclass(frozen=True)
class Located:
    """One attack on one frame.

    Args:
        frame: Which: its id; of a drive ``2011_09_26_drive_0052_sync/0000000003``.
        attack: Such as ``facula, camera 2, 225 px``.
        area: Pixels, or bogus points.
        lost: Points of the clean scan, of an attack that loses rays.
        error_before: In the true area of an image: mean difference to the clean image, grey levels.
        error_after: The same, repaired.
        objects: That a detector finds in the clean frame.
        found_before: How many of them it finds in the tampered one.
        found_after: In the repaired one.
    """

    frame: str
    attack: str
    area: Overlap
    lost: Overlap | None = None
    error_before: float | None = None
    error_after: float | None = None
    objects: int | None = None
    found_before: int | None = None
    found_after: int | None = None


def attacks_of(camera: int = 2) -> dict[str, OpticalAttack]:
    """The attacks that are tried, by what they are called."""
    faculae = {f"facula, camera {camera}, {radius:g} px": radius for radius in RADII}
    result: dict[str, OpticalAttack] = {
        name: Facula(camera, radius) for name, radius in faculae.items()
    }
    for lost in (False, True):
        for width in WIDTHS:
            name = f"bogus return, {width:g} m" + (", rays lost" if lost else "")
            result[name] = LidarSpoofing(width=width, rays_lost=lost)
    return result


def locate(
    frame: SensorFrame,
    system: SensorSystem,
    attacks: Mapping[str, OpticalAttack],
    *,
    seed: int = 0,
    detector: Detector | None = None,
) -> Iterator[tuple[Located, TamperedFrame, Repair]]:
    """Attack a frame, repair it and judge both.

    Args:
        frame: Clean.
        system: Its sensors; the attacked ones are named to the repair.
        attacks: By name.
        seed: Of the attacks' places.
        detector: Whose objects are counted, if any.
    """
    objects = None if detector is None else detector.detect(frame)
    for number, (name, attack) in enumerate(attacks.items()):
        tampered = attack.attack(frame, [seed, number])
        mended = repair(tampered.frame, system, tampered.attacked)
        row = _judged(frame, name, tampered, mended)
        if detector is not None and objects is not None:
            before, after = detector.detect(tampered.frame), detector.detect(mended.frame)
            row = replace(
                row,
                objects=len(objects),
                found_before=found_again(objects, before),
                found_after=found_again(objects, after),
            )
        yield row, tampered, mended


def overlap(found: NDArray[np.bool_], true: NDArray[np.bool_]) -> Overlap:
    """Compare two areas, or two sets of points, of one shape."""
    both, either = int((found & true).sum()), int((found | true).sum())
    return Overlap(
        both / either if either else None,
        both / int(found.sum()) if found.any() else None,
        both / int(true.sum()) if true.any() else None,
    )


def found_again(objects: Boxes3D, detections: Boxes3D) -> int:
    """How many objects overlap, by half in the image, with a detection of their category."""
    if not len(objects) or not len(detections):
        return 0
    assert objects.box2d is not None, "detectors give 2D boxes"
    assert detections.box2d is not None, "detectors give 2D boxes"
    low = np.maximum(objects.box2d[:, None, :2], detections.box2d[None, :, :2])
    high = np.minimum(objects.box2d[:, None, 2:], detections.box2d[None, :, 2:])
    common = np.prod(np.maximum(high - low, 0.0), axis=2)
    one, other = (
        np.prod(box[:, 2:] - box[:, :2], axis=1) for box in (objects.box2d, detections.box2d)
    )
    same = common >= _FOUND * (one[:, None] + other[None, :] - common)
    same &= objects.category[:, None] == detections.category[None, :]
    return int(same.any(axis=1).sum())


def summary(rows: Iterable[Located]) -> dict[str, dict[str, float | int | None]]:
    """Means by attack; objects are summed."""
    by_attack: dict[str, list[Located]] = {}
    for row in rows:
        by_attack.setdefault(row.attack, []).append(row)
    return {
        attack: {
            "frames": len(group),
            "iou": _mean(row.area.iou for row in group),
            "lowest_iou": min(
                (row.area.iou for row in group if row.area.iou is not None), default=None
            ),
            "precision": _mean(row.area.precision for row in group),
            "recall": _mean(row.area.recall for row in group),
            "iou_of_lost": _mean(row.lost.iou for row in group if row.lost),
            "error_before": _mean(row.error_before for row in group),
            "error_after": _mean(row.error_after for row in group),
            "objects": _sum(row.objects for row in group),
            "found_before": _sum(row.found_before for row in group),
            "found_after": _sum(row.found_after for row in group),
        }
        for attack, group in by_attack.items()
    }


def _judged(
    frame: SensorFrame,
    name: str,
    tampered: TamperedFrame,
    mended: Repair,
) -> Located:
    for camera, true in tampered.pixels.items():
        clean, attacked = frame.image(camera), tampered.frame.image(camera)
        return Located(
            frame.id,
            name,
            overlap(mended.pixels[camera], true),
            error_before=_difference(attacked, clean, true),
            error_after=_difference(mended.frame.image(camera), clean, true),
        )
    assert mended.scan is not None, "what attacks no camera attacks the LiDAR"
    assert tampered.points is not None, "bogus returns are points"
    lost = (
        None if tampered.lost is None else overlap(mended.scan.is_lost(frame.points), tampered.lost)
    )
    return Located(frame.id, name, overlap(mended.scan.points, tampered.points), lost)


def _difference(image: Image, clean: Image, area: NDArray[np.bool_]) -> float | None:
    if not area.any():
        return None
    return float(np.abs(image[area].astype(float) - clean[area]).mean())


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _sum(values: Iterable[int | None]) -> int | None:
    known = [value for value in values if value is not None]
    return sum(known) if known else None


def _moments(options: argparse.Namespace) -> Iterator[Moment]:
    if options.kitti is not None:
        data = KittiObject(options.kitti)
        ids = options.frame or data.ids(having=("image_2", "image_3", "velodyne"))
        yield from (Moment(id, partial(data.frame, id)) for id in ids)
        return
    if options.kitti_raw is not None:
        drives = [Drive(folder) for folder in options.kitti_raw]
    else:
        raw = world_drives()
        drives = [raw.drive(name) for name in raw.drives()]
    for drive in drives:
        for number in drive.frames(having=("image_02", "image_03", "velodyne_points")):
            id = f"{drive.name}/{number:010d}"
            yield Moment(id, partial(drive.frame, number, previous=0))


def _system(frame: SensorFrame) -> SensorSystem:
    every = set(KITTI_SYSTEM.cameras) <= set(frame.images)
    return KITTI_SYSTEM if every else LIDAR_AND_TWO_CAMERAS


def main(arguments: Sequence[str] | None = None) -> int:
    """Write ``localisation.json`` and a picture of each attack; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kitti", type=Path, help="object root")
    parser.add_argument("--frame", action="append", help="of it, such as 000107")
    parser.add_argument("--kitti-raw", type=Path, action="append", help="drive; default: the world")
    parser.add_argument("--frames", type=int, default=6, help="how many at most")
    parser.add_argument("--detector", help="whose objects are counted, such as stereo_rcnn")
    parser.add_argument("--seed", type=int, default=0, help="of the attacks' places")
    parser.add_argument("--out", type=Path, default=Path("runs/localisation"), help="folder")
    options = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    cv2.setNumThreads(1)
    rows: list[Located] = []
    try:
        detector = None if options.detector is None else make_detector(options.detector)
        for number, moment in enumerate(islice(_moments(options), options.frames)):
            frame = moment.frame()
            system = _system(frame)
            judged = locate(
                frame, system, attacks_of(), seed=options.seed + number, detector=detector
            )
            for row, tampered, mended in judged:
                rows.append(replace(row, frame=moment.id))
                _LOG.info("%s", rows[-1])
                picture = options.out / f"{number:02d} {row.attack}.png"
                save_picture(draw_repair(frame, tampered, mended), picture, overwrite=True)
        content = {"summary": summary(rows), "rows": [asdict(row) for row in rows]}
        text = json.dumps(content, indent=1, allow_nan=False) + "\n"
        write_text(options.out / "localisation.json", text, overwrite=True)
    except AvsecError as error:
        _LOG.error("%s", error)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
