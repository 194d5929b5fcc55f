"""The thesis' method by surfaces, by where the scans were taken from, and how surfaces are made.

The thesis' three vehicles are one that scans three times, half a second apart, in a street where
all stands: nearly the same viewpoint.  Vehicles that meet on a road see an object's other sides.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter4.procedural_instants import ScannedPlace
from avsec_gym.experiments.chapter4.settings import EXACT, FITTED, JUDGED, Part
from avsec_gym.experiments.json_rows import as_json, row_of
from avsec_gym.geometry import Floats
from avsec_gym.progress import Progress, no_progress
from avsec_gym.storage.json_lines import JsonLines
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject, pasteable_scans
from avsec_gym.validation.connected.attacks.removed_object import RemovedObject
from avsec_gym.validation.connected.base_station import SurfaceComparison
from avsec_gym.validation.connected.cropping import CropMargins
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.merged_proposals import MergedProposals, merge_proposals
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.surface_exchange import exchange_surfaces
from avsec_gym.validation.connected.surfaces.deformed_mesh import DeformedMesh
from avsec_gym.validation.connected.surfaces.delaunay import delaunay_mesh
from avsec_gym.validation.connected.surfaces.mesh import Mesher
from avsec_gym.validation.connected.traffic import SentMessages
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from avsec_gym.world.capture import Lidar, Sweep, renderer_of, scan_of
from avsec_gym.world.motion import later
from avsec_gym.world.posed_scenes import PosedScene

SEED = 14000
"""The seed of the places: of the sets 19000 and 20000, of which nothing else is made."""
APART, SUCCESSIVE = "three vehicles", "one vehicle, 0.5 s apart"
VIEWPOINTS = (SUCCESSIVE, APART)
"""The thesis' own scans first."""
SECONDS = (-0.5, 0.0, 0.5)
"""When the one vehicle scans."""
SIDES = (0.0, 0.25, 0.5)
"""Metres that are cropped beside a region."""
DELAUNAY, SHORT_EDGES, OPTIMISED = "Delaunay", "Delaunay, edges up to 1 m", "optimised"
MESHERS: Mapping[str, Mesher] = {
    DELAUNAY: delaunay_mesh,
    SHORT_EDGES: partial(delaunay_mesh, longest_edge=1.0),
    OPTIMISED: DeformedMesh(),
}
OPTIMISED_PLACES, OPTIMISED_REGIONS = 8, 3
"""Places of each part, and regions of each of their states, that are compared by optimised meshes,
too, without margins: a mesh takes seconds."""
GHOST, REMOVAL, CLEAN = "ghost", "removal", "clean"
_STANDS = 0.05
"""m/s: what is slower stands."""
_AWAY = 4.0
"""Metres that a region's middle is from all that moves, where scans are successive."""


@dataclass(frozen=True)
class RegionDistances:
    """The distances of a region's surfaces.

    Args:
        part: Whether thresholds come from it, or it is judged.
        place: Name of the place.
        viewpoints: One of `VIEWPOINTS`.
        state: ``clean``, or the attack that the region is about.
        mesher: One of `MESHERS`.
        sides: Metres cropped beside it.
        distances: The distances of the pairs that were compared, metres; of an attack, of those
            with the victim.
    """

    part: Part
    place: str
    viewpoints: str
    state: str
    mesher: str
    sides: float
    distances: tuple[float, ...]


@dataclass(frozen=True)
class PlaceResult:
    """All that is measured at a place.

    Args:
        regions: Every region that was compared, in each way.
        attacks: Attacks that were made, as viewpoints and state.
        covered: Those of them that a proposal is about.
        seconds: Time of all regions' surfaces, and the number of regions, by mesher.
    """

    regions: tuple[RegionDistances, ...] = ()
    attacks: tuple[tuple[str, str], ...] = ()
    covered: tuple[tuple[str, str], ...] = ()
    seconds: Mapping[str, tuple[float, int]] = field(default_factory=dict)


class KeptPlace(TypedDict):
    """A place in the file of what was measured."""

    id: str
    regions: list[Any]
    attacks: list[Any]
    covered: list[Any]
    seconds: dict[str, Any]


def measured_places(
    places: int, kept: JsonLines, seed: int = SEED, on_progress: Progress = no_progress
) -> list[PlaceResult]:
    """Measure places of both parts, as far as they have not been measured.

    Args:
        places: Number of places of each part.
        kept: Where measured places are kept.
        seed: Seed of the places.
        on_progress: Function of the places that are done, and of all.
    """
    todo = [(part, number) for number in range(places) for part in (FITTED, JUDGED)]
    found = []
    for done, (part, number) in enumerate(todo, start=1):
        id = f"{seed} {part} {number}"
        if id not in kept.rows:
            measured = as_json(measured_place(seed, part, number))
            assert isinstance(measured, dict)
            kept.add({"id": id, **measured})
        found.append(_read(kept.rows[id]))
        on_progress(done, len(todo))
    return found


def _read(row: dict[str, Any]) -> PlaceResult:
    """A place as it was kept."""
    return PlaceResult(
        tuple(row_of(RegionDistances, each) for each in row["regions"]),
        tuple((viewpoints, state) for viewpoints, state in row["attacks"]),
        tuple((viewpoints, state) for viewpoints, state in row["covered"]),
        {mesher: (seconds, regions) for mesher, (seconds, regions) in row["seconds"].items()},
    )


def measured_place(seed: int, part: Part, number: int) -> PlaceResult:
    """Measure a place from both viewpoints.

    Args:
        seed: Seed of the places.
        part: Part of the run, which decides the assets.
        number: Number of the place.
    """
    place = ScannedPlace(seed, part, number, len(SECONDS))
    apart = place.instant(EXACT)
    successive, moving = successive_instant(place.posed)
    scans = pasteable_scans(apart)
    random = (seed, number)
    result = PlaceResult()
    for viewpoints, instant in ((SUCCESSIVE, successive), (APART, apart)):
        states: list[tuple[str, AttackedInstant | None]] = [(CLEAN, None)]
        if part == JUDGED and scans:
            pasted = PastedObject(scan=scans[number % len(scans)])
            states.append((GHOST, pasted.attack(instant, random)))
        if part == JUDGED and viewpoints == APART:
            states.append((REMOVAL, RemovedObject().attack(instant, random)))
        for state, attacked in states:
            if state != CLEAN and attacked is None:
                continue
            seen = instant if attacked is None else attacked.instant
            away = moving if viewpoints == SUCCESSIVE else np.zeros((0, 2))
            named = RegionDistances(part, f"{part} {number}", viewpoints, state, "", 0.0, ())
            result = _joined(result, compared(seen, attacked, named, away, number))
    return result


def successive_instant(posed: PosedScene) -> tuple[RecordedInstant, Floats]:
    """What the first vehicle scans at `SECONDS`, as if it were three, and where something moves.

    Args:
        posed: What is there, with its vehicles.

    Returns:
        The instant, without labels; and positions of all that moves, then and in between, (N, 2).
    """
    scans, moving = [], []
    for seconds in SECONDS:
        seen = later(posed, seconds)
        points = scan_of(seen, 0, Lidar(), Sweep.INSTANT, renderer_of(seen, 0)).points
        scans.append(VehicleScan(points, seen.vehicle_to_world[0] @ seen.rig.velodyne_pose))
        actors = seen.instant.actors
        moving.append(actors.pose[np.abs(actors.speed) > _STANDS][:, :2])
    poses = tuple(scan.pose for scan in scans)
    return RecordedInstant("", tuple(scans), None, poses), np.concatenate(moving)


def compared(
    instant: RecordedInstant,
    attacked: AttackedInstant | None,
    named: RegionDistances,
    moving: Floats,
    number: int,
) -> PlaceResult:
    """Compare the surfaces of an instant's regions in each way.

    Args:
        instant: What is compared.
        attacked: The attack on it; None: there is none.
        named: What its regions are called.
        moving: Where something moves, shape (N, 2); regions near it are left out.
        number: Number of the place; the first ones are compared by optimised meshes, too.
    """
    vehicles = len(instant.scans)
    merged = merge_proposals(instant.scans, ClusterProposer(), SentMessages(vehicles), None)
    about = _about(merged.regions.centre, moving)
    attack: tuple[tuple[str, str], ...] = ()
    if attacked is not None:
        about &= attacked.regions(merged.regions)
        attack = ((named.viewpoints, named.state),)
    covered = attack if about.any() else ()
    found: list[RegionDistances] = []
    seconds: dict[str, tuple[float, int]] = {}
    epsilon = read_connected_fit(SHIPPED_FIT).constants().epsilon
    chosen = np.flatnonzero(about)
    for mesher, sides in ways(number):
        taken = _some(merged, chosen[:OPTIMISED_REGIONS] if mesher == OPTIMISED else chosen)
        comparison = SurfaceComparison(MESHERS[mesher], epsilon, CropMargins(sides=sides))
        traffic = SentMessages(vehicles)
        distances = exchange_surfaces(instant.scans, taken, comparison, traffic).distances
        if sides == SIDES[0]:
            seconds[mesher] = traffic.seconds["compare"], len(distances)
        for each in distances:
            pairs = (
                each[np.triu_indices(vehicles, 1)] if attacked is None else each[attacked.victim]
            )
            known = tuple(pairs[np.isfinite(pairs)].round(4).tolist())
            found.append(replace(named, mesher=mesher, sides=sides, distances=known))
    return PlaceResult(tuple(found), attack, covered, seconds)


def ways(number: int) -> Iterator[tuple[str, float]]:
    """Meshers and margins by which a place is compared.

    Args:
        number: Number of the place.
    """
    for mesher in (DELAUNAY, SHORT_EDGES):
        for sides in SIDES:
            yield mesher, sides
    if number < OPTIMISED_PLACES:
        yield OPTIMISED, SIDES[0]


def _some(merged: MergedProposals, index: NDArray[np.intp]) -> MergedProposals:
    """Some of the regions alone."""
    few = replace(merged.complete_set, regions=merged.complete_set.regions[index])
    return replace(merged, complete_set=few, regions=merged.regions[index])


def _about(centre: Floats, moving: Floats) -> NDArray[np.bool_]:
    """Which regions are away from all that moves, shape (R,)."""
    if not len(moving) or not len(centre):
        return np.ones(len(centre), bool)
    apart = np.linalg.norm(centre[:, None, :2] - moving[None], axis=2)
    return np.asarray(apart.min(axis=1) >= _AWAY)


def _joined(first: PlaceResult, second: PlaceResult) -> PlaceResult:
    seconds = dict(first.seconds)
    for mesher, (more, regions) in second.seconds.items():
        before, count = seconds.get(mesher, (0.0, 0))
        seconds[mesher] = before + more, count + regions
    return PlaceResult(
        first.regions + second.regions,
        first.attacks + second.attacks,
        first.covered + second.covered,
        seconds,
    )
