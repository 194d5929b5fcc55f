"""`avsec disparity`: disparities scored as KITTI's stereo benchmarks do."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple

from avsec_gym import console
from avsec_gym.argument_checks import resample_number, seed_number, whole_number
from avsec_gym.commands.named_part import named_part
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.regular_files import is_folder

if TYPE_CHECKING:
    from avsec_gym.frame import SensorFrame
    from avsec_gym.kitti.map_files import Disparity
    from avsec_gym.metrics.disparity_errors import DisparityRates, ErrorRate, Errors
    from avsec_gym.perception.depth import DepthEstimator

_REMARKS = 10
"""So many pairs that were left out are reported one by one."""
_MEASURES = ("error, px", "> 3 px, %", "D1, %")


@dataclass(frozen=True)
class ScoreDisparities:
    """End-point error, pixels off by more than 3 (stereo 2012) and D1 (stereo 2015) of disparities.

    Over the pixels where something was found, and over all that have truth (D1-all), holes filled
    as KITTI's development kit fills them.
    """

    kitti: Path
    """KITTI stereo 2012 or 2015 (the folder that holds training), or a folder in the object layout
    with true disparities, as `avsec world make` writes it."""
    depth: tuple[str, ...] = ("sgbm", "psmnet")
    """How disparities are found: names, or JSON with arguments, '{"name": "sgbm", "block": 3}'."""
    disparities: Path | None = None
    """Folder of disparity maps that are judged instead, 16-bit PNGs named as the left images."""
    truth: Literal["occ", "noc"] = "occ"
    """The pixels of KITTI's truth: all (occ), or those that both cameras see (noc)."""
    limit: int | None = None
    """Only the first pairs."""
    resamples: int = 0
    """Pairs are drawn anew so many times for 95 % bootstrap intervals, such as 1000; 0: none."""
    seed: int = 0
    """Seed of these draws."""
    json: bool = False
    """Instead of a table, {"schema": ..., "pairs": N, "truth": ..., "estimators": {name:
    {"density": {"value", "interval"}, "found"|"all": {"end_point_error"|"off_3px"|"d1":
    {"value", "interval"}}}}}; pixels, and shares of 1."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.metrics.disparity_errors import disparity_errors, error_rates

        if self.limit is not None:
            whole_number("--limit", self.limit, 1)
        resample_number("--resamples", self.resamples)
        seed_number("--seed", self.seed)
        finders = self._finders()
        data = _pairs(self.kitti, self.truth)
        ids = data.ids[: self.limit]
        # A pair counts for all estimators or for none, so that their rates are of the same pairs.
        errors: dict[str, list[Errors]] = {name: [] for name in finders}
        left_out: dict[str, DataError] = {}
        with console.progress("matching") as shown:
            for done, id in enumerate(ids, start=1):
                try:
                    frame, truth = data.read(id)
                    of_pair = {
                        name: disparity_errors(_fitting(find(id, frame), truth, id), truth)
                        for name, find in finders.items()
                    }
                except DataError as problem:
                    left_out[id] = problem
                else:
                    for name, of_one in of_pair.items():
                        errors[name].append(of_one)
                shown(done, len(ids))
        if len(left_out) == len(ids):
            raise next(iter(left_out.values()))
        for error in list(left_out.values())[:_REMARKS]:
            console.say(f"avsec: left out: {error}")
        if len(left_out) > _REMARKS:
            console.say(f"avsec: left out: {len(left_out) - _REMARKS} more pairs")
        rates = {name: error_rates(e, self.resamples, self.seed) for name, e in errors.items()}
        pairs = len(ids) - len(left_out)
        if self.json:
            estimators = {name: asdict(of_one) for name, of_one in rates.items()}
            document = {"pairs": pairs, "truth": data.truth, "estimators": estimators}
            console.print_json("disparity", document)
        else:
            _show(rates, f"{self.kitti}: {data.name}, {pairs} pairs, truth {data.truth}")
        return console.DONE_IN_PART if left_out else console.DONE

    def _finders(self) -> dict[str, Callable[[str, SensorFrame], Disparity]]:
        """What gives the disparities of a pair, by the name that the table has.

        Raises:
            ConfigurationError: An estimator is unknown or its arguments do not fit, or none is
                named.
            DataError: There is no folder of maps.
        """
        if self.disparities is not None:
            from avsec_gym.kitti.map_files import read_disparity

            folder = self.disparities
            if not is_folder(folder):
                raise DataError("There is no such folder.", path=folder, remedy="Check the path.")
            return {folder.name: lambda id, _: read_disparity(folder / f"{id}.png")}
        from avsec_gym.perception.depth import make_depth

        if not self.depth:
            raise ConfigurationError("--depth names one estimator or more")
        made = {what: make_depth(named_part(what, "--depth")) for what in self.depth}

        def finder(estimator: DepthEstimator) -> Callable[[str, SensorFrame], Disparity]:
            return lambda _, frame: estimator.disparity(frame).values

        return {what: finder(estimator) for what, estimator in made.items()}


class _Pairs(NamedTuple):
    """Pairs of images with truth."""

    name: str
    truth: str
    """What the truth is."""
    ids: list[str]
    """One or more."""
    read: Callable[[str], tuple[SensorFrame, Disparity]]


def _pairs(root: Path, truth: Literal["occ", "noc"]) -> _Pairs:
    """Of KITTI's stereo benchmarks, or of a data set with dense truth.

    Raises:
        DataError: There are none.
    """
    from avsec_gym.kitti import KittiObject, KittiStereo
    from avsec_gym.kitti.layouts import stereo_folders
    from avsec_gym.perception.depth.ground_truth import GroundTruthDepth

    if stereo_folders(root):
        stereo = KittiStereo(root)
        kind = stereo.layout.truth[truth]
        ids = stereo.ids(having=(kind,))
        found = _Pairs(
            f"KITTI {stereo.layout.name}",
            kind,
            ids,
            lambda id: (stereo.frame(id), stereo.disparity(id, truth)),
        )
    else:
        data, known = KittiObject(root), GroundTruthDepth()
        kind = f"disparity_{known.left}"
        folder = data.folder / kind
        ids = [
            id
            for id in data.ids(having=("image_2", "image_3", "calib"))
            if (folder / f"{id}.png").is_file()
        ]

        def read(id: str) -> tuple[SensorFrame, Disparity]:
            frame = data.frame(id)
            return frame, known.disparity(frame).values

        found = _Pairs("object layout", kind, ids, read)
    if not found.ids:
        raise DataError(
            f"No pair of images here has a true disparity in {kind}/.",
            path=root,
            remedy="KITTI's stereo archives have them in training/, and `avsec world make` writes "
            "them.",
        )
    return found


def _fitting(found: Disparity, truth: Disparity, id: str) -> Disparity:
    """What was found, of the size of the truth.

    Raises:
        DataError: It is not.
    """
    if found.shape != truth.shape:
        raise DataError(
            f"Pair {id}: a disparity map has {found.shape[1]}x{found.shape[0]} pixels, the truth "
            f"{truth.shape[1]}x{truth.shape[0]}.",
            remedy="Maps have the size of the left image.",
        )
    return found


def _show(rates: dict[str, DisparityRates], title: str) -> None:
    columns = ["estimator", "found, %"]
    columns += [f"{part}: {what}" for part in ("found", "all") for what in _MEASURES]
    console.print_table(title, columns, [[name, *_cells(rates[name])] for name in rates])


def _cells(rates: DisparityRates) -> Iterator[str]:
    yield _cell(rates.density, 100)
    for part in (rates.found, rates.all):
        yield _cell(part.end_point_error, 1)
        yield _cell(part.off_3px, 100)
        yield _cell(part.d1, 100)


def _cell(rate: ErrorRate, scale: float) -> str:
    if rate.value is None:
        return "–"
    text = f"{scale * rate.value:.2f}"
    if rate.interval is None:
        return text
    low, high = (f"{scale * bound:.2f}" for bound in rate.interval)
    return f"{text} ({low}–{high})"
