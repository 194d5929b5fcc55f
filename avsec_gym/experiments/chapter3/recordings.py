"""The data of chapter 3: drives of a rig whose cameras stand far enough from each other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from avsec_gym.argument_checks import one_of
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.experiments.procedural_frames import PROCEDURAL, check_place
from avsec_gym.rig import camera_rig
from avsec_gym.runs.experiment import Cell, Configuration
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import FittedOn, fitted_on
from avsec_gym.validation.recordings import Recordings, raw_recordings
from avsec_gym.world.assets import Assets
from avsec_gym.world.export import (
    Sensors,
    cache_folder,
    cached,
    read_manifest,
    suite_recipe,
    world_fingerprint,
)

RIG = camera_rig((0.0, 0.54, -0.27, 0.27))
"""Camera 2 is the leftmost one, and camera 0, 3 and 1 follow, each 27 cm farther right; those of
KITTI stand in pairs of 6 cm."""
SYSTEM = SensorSystem((LIDAR, 1, 3, 2))
"""The thesis' LiDAR and three cameras, of this rig as of KITTI's."""
FITTED, JUDGED = "fitted", "judged"
"""The two parts of a run: recordings that thresholds and likelihoods come from, and others."""
JUDGED_ASSETS = {"judged_assets": str(Assets.JUDGE)}
"""``judged_assets``: the part of the assets that procedural drives to judge are made of, see
`Assets`: ``train``, ``judge`` or ``all``."""
PART_OPTIONS = {
    "fit": "",
    "fit_limit": 0,
    "fit_seed": -1,
    "fitted_assets": str(Assets.TRAIN),
    **JUDGED_ASSETS,
}
"""``fit``: KITTI raw drives to fit on, procedural ones if empty; ``fit_limit``: how many of their
frames, as many as are judged if 0; ``fit_seed``: of procedural drives to fit on and of the attacks
on them, the run's own if negative, so that new drives can be judged by what others were fitted on;
``fitted_assets``: the part of the assets that procedural drives to fit on are made of, and
`JUDGED_ASSETS`: nothing is judged on cars, houses and textures that it was fitted on, as made."""
OPTIONS = {**PART_OPTIONS, "depth": "sgbm"}
"""`PART_OPTIONS`, and ``depth``: how disparities are found."""
USUAL_COUNT = 1000

_ASSETS_IN_WORDS = {
    Assets.TRAIN: "training assets",
    Assets.JUDGE: "judging assets",
    Assets.ALL: "all assets",
}
_FIRST_SET = {FITTED: 3000, JUDGED: 4000}
"""Numbers of the sets of drives, none of which anything else was made from."""


def procedural_drives(
    count: int, seed: int, part: str, drive_frames: int = 1, assets: Assets | None = None
) -> Path:
    """Four cameras and a LiDAR in KITTI's raw layout; made in the user's cache on first use.

    The first frames of many are the frames of few: of sets that are there, the smallest that has
    as many serves, and may have more.

    Args:
        count: The number of frames, at least.
        seed: Seed of the drives; other seeds are other drives.
        part: `FITTED` or `JUDGED`, which never share a drive.
        drive_frames: The number of frames of each drive. Frames of one drive are alike, so that a
            thousand drives are more evidence than a thousand frames of a few.
        assets: The part of the assets that they are made of; None: as `OPTIONS` has it for the
            part, so that both share no car, house, tree or texture.

    Raises:
        ConfigurationError: There cannot be so many, or the seed is not from 0 to 999.
        DataError: The cache cannot be written.
    """
    if not 0 <= seed < 1000:
        raise ConfigurationError(f"a seed of drives is from 0 to 999, got {seed}")
    assets = _assets_of({}, part) if assets is None else assets
    kind = f"chapter_3-{part}-{seed}-{{}}-{drive_frames}-{assets}"
    count = min(_counts_there(kind, at_least=count), default=count)
    recipe = suite_recipe(
        "raw",
        count,
        _FIRST_SET[part] + seed,
        sensors=Sensors(rig=RIG),
        drive_frames=drive_frames,
        assets=assets,
    )
    return cached(kind.format(count), recipe)


def _counts_there(kind: str, at_least: int) -> Iterator[int]:
    """How many frames the complete sets of a kind have, of those in the cache."""
    suites, fingerprint = cache_folder() / "suites", world_fingerprint()
    for root in suites.glob(f"{kind.format('*')}-{fingerprint}"):
        # A broken set is an error where it is asked for by its own name.
        manifest = None
        with suppress(DataError):
            manifest = read_manifest(root)
        if manifest is not None and manifest["complete"]:
            count = int(root.name.split("-")[3])
            if count >= at_least:
                yield count


def recordings_of(
    configuration: Configuration,
    part: str,
    drive_frames: int = 1,
    system: SensorSystem = SYSTEM,
) -> Recordings:
    """The frames of a part of a run.

    Args:
        configuration: The configuration of the run.
        part: `FITTED` or `JUDGED`.
        drive_frames: The frames of each procedural drive.
        system: Which a frame has all sensors of.

    Raises:
        ConfigurationError: A name is mistyped, of a place or of a part of the assets.
        DataError: A folder is not there, or has no frame of all sensors.
    """
    options = {**OPTIONS, **configuration.options}
    count = configuration.limit or USUAL_COUNT
    place = configuration.scenarios
    if part == FITTED:
        count, place = options["fit_limit"] or count, options["fit"] or PROCEDURAL
    if place == PROCEDURAL:
        assets = _assets_of(configuration.options, part)
        root: str | Path = procedural_drives(
            count, seed_of(configuration, part), part, drive_frames, assets
        )
    else:
        check_place(place)
        root = place
    found = raw_recordings(root, system.sensors)
    return replace(found, frames=found.frames[:count])


def seed_of(configuration: Configuration, part: str) -> int:
    """The seed of the procedural drives of a part of a run, and of the attacks on them."""
    own: int = {**OPTIONS, **configuration.options}["fit_seed"]
    return own if part == FITTED and own >= 0 else configuration.seed


def assets_in_words(configuration: Configuration) -> list[str]:
    """Which assets the procedural drives of a run are made of, as remarks for its page.

    Empty where the run has real drives alone, and of runs from before there was a choice.
    """
    options = configuration.options
    fitted = options.get("fitted_file") or options.get("fit") or PROCEDURAL
    places = {JUDGED: configuration.scenarios, FITTED: fitted}
    shown = {JUDGED: "judged", FITTED: "fitted on"}
    words = [
        f"The procedural drives that are {shown[part]} are made of {_ASSETS_IN_WORDS[assets]}."
        for part, place in places.items()
        if (assets := options.get(f"{part}_assets")) in _ASSETS_IN_WORDS and place == PROCEDURAL
    ]
    return [" ".join(words)] if words else []


def _assets_of(options: Mapping[str, Any], part: str) -> Assets:
    name = f"{part}_assets"
    return Assets(one_of(f"option {name}", {**OPTIONS, **options}[name], Assets))


def frame_cells(
    work: str,
    configuration: Configuration,
    parts: Iterable[str],
    system: SensorSystem = SYSTEM,
    **arguments: Any,
) -> list[Cell]:
    """A cell for every frame, part by part; its arguments are ``part``, ``number``, and others.

    Args:
        work: The place of the work, see `Cell`.
        configuration: The configuration of the run.
        parts: `FITTED`, `JUDGED`, or both.
        system: The sensors, see `recordings_of`.
        arguments: Further arguments, the same for all cells.

    Raises:
        ConfigurationError: The fitted part is of another rig than the judged one, or shares frames
            with it.
    """
    parts = tuple(parts)
    if {FITTED, JUDGED} <= {*parts}:
        check_parts(configuration, system)
    return [
        Cell.of(work, recorded.id.partition("/")[0], part=part, number=number, **arguments)
        for part in parts
        for number, recorded in enumerate(recordings_of(configuration, part, system=system).frames)
    ]


def fitted_to(configuration: Configuration, system: SensorSystem = SYSTEM) -> FittedOn:
    """What thresholds and likelihoods of a run hold for."""
    options = {**OPTIONS, **configuration.options}
    frame = recordings_of(configuration, FITTED, system=system).frames[0].frame()
    data = {"drives": options["fit"] or PROCEDURAL, "seed": seed_of(configuration, FITTED)}
    return fitted_on(system, PairDepth(options["depth"]), frame.calibration, data)


def check_parts(configuration: Configuration, system: SensorSystem = SYSTEM) -> None:
    """Check that both parts are of one rig and have no frame in common; nothing is rendered for it.

    Raises:
        ConfigurationError: They are not.
    """
    options = {**OPTIONS, **configuration.options}
    places = {FITTED: options["fit"] or PROCEDURAL, JUDGED: configuration.scenarios}
    real = {
        part: recordings_of(configuration, part, system=system)
        for part, place in places.items()
        if place != PROCEDURAL
    }
    remedy = "name other drives of the same rig by --options fit=FOLDER"
    if len(real) == len(places) and (both := _in_common(real[FITTED], real[JUDGED])):
        raise ConfigurationError(
            f"{both} of the {len(real[JUDGED].frames)} frames in {places[JUDGED]} would be judged"
            f" by what was fitted on themselves: {remedy}"
        )
    ours, theirs = (
        real[part].frames[0].frame().calibration if part in real else RIG.calibration
        for part in (FITTED, JUDGED)
    )
    depth = PairDepth()
    try:
        fitted_on(system, depth, ours, {}).check(system, depth, theirs)
    except ConfigurationError as error:
        raise ConfigurationError(f"{places[JUDGED]}: {error}; {remedy}") from error


def _in_common(fitted: Recordings, judged: Recordings) -> int:
    """How many frames both have, where one's folder lies in the other's."""
    first, second = (part.root.resolve() for part in (fitted, judged))
    if first not in (second, *second.parents) and second not in first.parents:
        return 0
    of_fitted, of_judged = (
        {(recorded.drive, recorded.id.rpartition("/")[2]) for recorded in part.frames}
        for part in (fitted, judged)
    )
    return len(of_fitted & of_judged)


def drives_inputs(
    configuration: Configuration, parts: Iterable[str], system: SensorSystem = SYSTEM
) -> dict[str, Path]:
    """The manifests of procedural drives, which are rendered if they are not there.

    Args:
        configuration: The configuration of the run.
        parts: `FITTED`, `JUDGED`, or both.
        system: The sensors, see `recordings_of`.

    Raises:
        ConfigurationError: See `check_parts`.
        DataError: As `recordings_of`.
    """
    parts = tuple(parts)
    if {FITTED, JUDGED} <= {*parts}:
        check_parts(configuration, system)
    roots = {
        f"{part} drives": recordings_of(configuration, part, system=system).root for part in parts
    }
    manifests = {name: root / "manifest.json" for name, root in roots.items()}
    return {name: path for name, path in manifests.items() if path.is_file()}
