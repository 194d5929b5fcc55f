"""What a patch can cost: true detections, and one or two ghosts of a size at a distance.

No detector, image or training has a part in it: the planner gets the labelled objects, and the
ghosts b* of patches that would work every time.  A patch that stands where these do, and does not
hide objects, costs no more on average.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from avsec_gym.attacks.attack import LEFT, Seed
from avsec_gym.attacks.patch_ghosts import FULL_CAR, ghost_box
from avsec_gym.attacks.patch_placement import RADIUS, PatchPlace, focal_times_baseline
from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.planner import MotionPrimitivePlanner, Planner
from avsec_gym.progress import Progress, no_progress
from avsec_gym.rig import kitti_rig
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.corrected_episodes import gain

WIDTHS: tuple[float | None, ...] = (None, 1.0, FULL_CAR[1])
"""Metres; None: what a patch of the thesis' radius shows of a car at its distance."""
BINS = ((5.0, 8.0), (8.0, 12.0), (12.0, 16.0), (16.0, 20.0))
"""Metres from the camera to the ghost's rear, each beginning where the one before ends."""
DISTANCES = (*BINS, (8.0, 20.0), (5.0, 12.0))
"""And two that are wider: all that patches are trained for, and the nearest half."""
COUNTS = (1, 2)
"""Ghosts at once."""
_WIDTH = 1242
"""Columns of an image."""
_CALIBRATION = kitti_rig().calibration


@dataclass(frozen=True)
class TruthRow:
    """A car that sees the labelled objects and no ghost.

    Args:
        intention: The driving intention.
        rates: The three rates.
    """

    intention: Intention
    rates: SafetyRates


@dataclass(frozen=True)
class CeilingRow:
    """A car that sees the labelled objects, and ghosts.

    Args:
        ghosts: Number of ghosts at once.
        width: Width of a ghost, metres; None: what the patch shows of a car.
        nearest: Least distance of its rear, metres.
        farthest: Largest distance, metres.
        intention: The driving intention, to whose third of the image the ghosts belong.
        rates: The three rates.
        gain: Safe driving gained against the truth alone, percentage points, with its 95 % interval
            by bootstrap over scenarios; what a ghost costs is below 0.
    """

    ghosts: int
    width: float | None
    nearest: float
    farthest: float
    intention: Intention
    rates: SafetyRates
    gain: Estimate

    @property
    def words(self) -> str:
        """The kind of ghosts for readers, such as ``two full``."""
        return kind_in_words(self.ghosts, self.width)

    @property
    def distances(self) -> tuple[float, float]:
        """Nearest and farthest."""
        return self.nearest, self.farthest


@dataclass(frozen=True)
class GhostCeilings:
    """All of them.

    Args:
        scenarios: Number of scenarios.
        seed: Seed of the places.
        truth: A row for each intention.
        rows: A row for each kind of ghosts and each intention.
    """

    scenarios: int
    seed: int
    truth: Sequence[TruthRow]
    rows: Sequence[CeilingRow]

    def alone(self, intention: Intention) -> SafetyRates:
        """The rates without a ghost."""
        (rates,) = (row.rates for row in self.truth if row.intention == intention)
        return rates

    def of(self, intention: Intention, ghosts: int, width: float | None) -> Sequence[CeilingRow]:
        """The rows of a kind of ghosts, in the order of `DISTANCES`."""
        kind = (intention, ghosts, width)
        return [row for row in self.rows if (row.intention, row.ghosts, row.width) == kind]


def kind_in_words(ghosts: int, width: float | None) -> str:
    """A kind of ghosts for readers.

    Args:
        ghosts: Number of ghosts.
        width: One of `WIDTHS`.

    Example:
        >>> kind_in_words(2, 1.0)
        'two 1 m wide'
    """
    size = {None: "as seen", FULL_CAR[1]: "full"}.get(width, f"{width or 0:g} m wide")
    return f"{('one', 'two')[ghosts - 1]} {size}"


def safe_interval(rates: SafetyRates) -> tuple[float, float]:
    """The 95 % interval of the safe driving rate."""
    low, high = rates.to_json()["safe_driving_rate_interval"]
    return low, high


def ghost_ceilings(
    scenes: Sequence[Scene],
    seed: int = 0,
    *,
    planner: Planner | None = None,
    on_progress: Progress = no_progress,
) -> GhostCeilings:
    """Rates of cars that see the truth and ghosts, for every size, distance and number.

    A scenario's places hang on the seed, its number, the intention and the distances: ghosts of all
    sizes stand at the same ones, and two ghosts are the one and another.

    Args:
        scenes: The scenes.
        seed: Seed of the places.
        planner: The motion planner; None: A* over motion primitives.
        on_progress: Function that gets the number of scenes that are done, and of all.
    """
    planner = MotionPrimitivePlanner() if planner is None else planner
    truth: dict[Intention, list[SafetyRecord]] = {intention: [] for intention in Intention}
    kinds = [*product(COUNTS, WIDTHS, DISTANCES, Intention)]
    records: dict[tuple[int, float | None, tuple[float, float], Intention], list[SafetyRecord]]
    records = {kind: [] for kind in kinds}
    for number, scene in enumerate(scenes):
        for intention in Intention:
            truth[intention].append(_record(scene, intention, scene.boxes, planner))
        for count, width, distances, intention in kinds:
            places = ghost_places(intention, distances, _seed(seed, scene, intention, distances))
            ghosts = [
                ghost_box(place, _CALIBRATION, width)
                for place, _ in zip(places, range(count), strict=False)
            ]
            believed = Boxes3D.concatenate([scene.boxes, *ghosts])
            record = _record(scene, intention, believed, planner)
            records[count, width, distances, intention].append(record)
        on_progress(number + 1, len(scenes))
    return GhostCeilings(
        len(scenes),
        seed,
        [TruthRow(intention, SafetyRates.of(own)) for intention, own in truth.items()],
        [
            CeilingRow(
                count,
                width,
                *distances,
                intention,
                SafetyRates.of(own),
                gain(truth[intention], own),
            )
            for (count, width, distances, intention), own in records.items()
        ],
    )


def ghost_places(
    intention: Intention, distances: tuple[float, float], seed: Seed
) -> Iterator[PatchPlace]:
    """Places of a specific patch, without end: the next ghost stands at the next one.

    The distance is uniform in metres, so that a range does not stand for its near end alone; the
    column is uniform in the third of the image that the intention points to, as far as both views
    show the whole patch.  A ghost's row is that of the horizon, since planning looks from above.

    Args:
        intention: The driving intention.
        distances: Least and largest distance, metres.
        seed: Seed of the draw.
    """
    draw, third = np.random.default_rng(seed), list(Intention).index(intention)
    horizon = float(_CALIBRATION.projection(LEFT)[1, 2])
    while True:
        disparity = focal_times_baseline(_CALIBRATION) / draw.uniform(*distances)
        first = max(third * _WIDTH / 3, RADIUS + disparity)
        last = min((third + 1) * _WIDTH / 3, _WIDTH - 1 - RADIUS)
        yield PatchPlace(draw.uniform(first, last), horizon, disparity)


def _seed(
    seed: int, scene: Scene, intention: Intention, distances: tuple[float, float]
) -> list[int]:
    return [seed, scene.number, list(Intention).index(intention), DISTANCES.index(distances) + 1]


def _record(
    scene: Scene, intention: Intention, believed: Boxes3D, planner: Planner
) -> SafetyRecord:
    episode = run_episode(scene, intention, believed, motion=Motion.TRUTH, planner=planner)
    return episode.record
