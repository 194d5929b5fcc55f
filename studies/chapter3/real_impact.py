"""What optical attacks do to detectors on real frames of KITTI (section 3.2.4): cars are counted.

Too few frames are at hand for a precision.  From which score on a box counts, is each detector's
working point on labelled frames of the world, which the attacks do not touch.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.experiments.chapter3.objects.bogus_obstacles import (
    bogus_patch,
    taken_for_an_obstacle,
)
from avsec_gym.experiments.chapter3.objects.detector_weights import image_detector, lidar_detector
from avsec_gym.experiments.chapter3.objects.pasted_cars import (
    CarInView,
    pasted_box,
    scans_of_cars,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.metrics.working_point import FROM_ABOVE, IN_IMAGE, counted, working_point
from studies.chapter3.real_frames_result import DetectorImpacts, ImageImpact, ScanImpact

CAMERA = 2
_LABELLED = ("label_2", "calib", f"image_{CAMERA}")

Look = Callable[[SensorFrame], Boxes3D]


def impact_on_real_frames(real: KittiObject, clean: KittiObject, draws: int) -> DetectorImpacts:
    """The thesis' attacks, one at a time, on every frame that has what a detector looks at.

    Args:
        real: The real frames, which are attacked.
        clean: Labelled frames of the world, with scans.
        draws: The number of draws of the attacks on each frame.

    Raises:
        DataError: A file is broken.
    """

    def in_scans(name: str) -> ScanImpact | None:
        if not (ids := _labelled(real, "velodyne")):
            return None
        look = lidar_detector(name, {}).detect
        score = _score(clean, "velodyne", look, FROM_ABOVE)
        return _bogus_returns(real, ids, look, score, draws)

    def in_images(name: str) -> ImageImpact | None:
        if not (ids := _labelled(real, f"image_{CAMERA}")):
            return None
        detector = image_detector(name, {})

        def look(frame: SensorFrame) -> Boxes3D:
            return detector.detect(frame, CAMERA)

        score = _score(clean, f"image_{CAMERA}", look, IN_IMAGE)
        return _faculae(real, ids, look, score, draws)

    return DetectorImpacts(
        in_scans("pixor"), in_scans("pointrcnn"), in_images("faster_rcnn"), in_images("yolo")
    )


def _labelled(data: KittiObject, folder: str) -> list[str]:
    """Frames with labels and what is looked at."""
    # A folder that is not there holds no frames.
    with suppress(DataError):
        return data.ids(having=(*_LABELLED, folder))
    return []


def _score(clean: KittiObject, folder: str, look: Look, seen: int) -> float:
    known = _labelled(clean, folder)
    truth = [clean.labels(id, keep_dont_care=True) for id in known]
    point = working_point(truth, [look(clean.frame(id)) for id in known], seen)
    if point is None:
        raise DataError("A detector finds no car at all.", path=clean.root)
    return point.score


def _bogus_returns(
    real: KittiObject, ids: Sequence[str], look: Look, score: float, draws: int
) -> ScanImpact:
    attack = LidarSpoofing(reference=CAMERA)
    scans = {id: scans_of_cars(real.frame(id), real.labels(id)) for id in ids}
    hits: dict[str, list[bool]] = {}
    of: dict[str, list[str]] = {}
    for id in ids:
        frame = real.frame(id)
        clean = above(look(frame), score)
        others = [scan for other in ids if other != id for scan in scans[other]]
        for draw in range(draws):
            seed = (draw, int(id))
            plane = attack.attack(frame, seed)
            looks = [("", plane, bogus_patch(plane))]
            if others:
                scan = others[draw % len(others)]
                car = CarInView(scan, CAMERA).attack(frame, seed)
                looks.append(("car_", car, pasted_box(scan, car)))
            for kind, tampered, place in looks:
                attacked = above(look(tampered.frame), score)
                for state, found in (("taken", attacked), ("already", clean)):
                    name = f"{kind}{state}"
                    hits.setdefault(name, []).append(taken_for_an_obstacle(found, place))
                    of.setdefault(name, []).append(id)
    shares = {name: share_of(hits[name], of[name]) for name in hits}
    return ScanImpact(score, ids, **shares)


def _faculae(
    real: KittiObject, ids: Sequence[str], look: Look, score: float, draws: int
) -> ImageImpact:
    attack = Facula(CAMERA)
    hits: dict[bool, list[bool]] = {False: [], True: []}
    of: dict[bool, list[str]] = {False: [], True: []}
    wrong = {False: 0, True: 0}
    for id in ids:
        frame, truth = real.frame(id), real.labels(id, keep_dont_care=True)
        looks = [(False, frame)]
        looks += [(True, attack.attack(frame, (draw, int(id))).frame) for draw in range(draws)]
        for attacked, source in looks:
            count = counted([truth], [above(look(source), score)], IN_IMAGE)
            hits[attacked] += [True] * count.found + [False] * count.missed
            of[attacked] += [id] * (count.found + count.missed)
            wrong[attacked] += count.false_alarms
    return ImageImpact(
        score,
        ids,
        found=share_of(hits[False], of[False]),
        found_attacked=share_of(hits[True], of[True]),
        false_alarms=wrong[False] / len(ids),
        false_alarms_attacked=wrong[True] / (draws * len(ids)),
    )
