"""What `avsec validate` makes of clean moments: thresholds, or a likelihood model."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from avsec_gym import console
from avsec_gym.errors import ConfigurationError, DataError

if TYPE_CHECKING:
    from avsec_gym.frame import SensorFrame
    from avsec_gym.geometry import Floats
    from avsec_gym.sensor_system import SensorSystem
    from avsec_gym.validation.evidence.pair_depth import PairDepth
    from avsec_gym.validation.fitted_on import FittedOn
    from avsec_gym.validation.moments import Moment


@dataclass(frozen=True)
class CleanMoments:
    """Moments to fit on; a file that is there already is left as it is.

    Args:
        moments: One or more.
        system: The sensors.
        depth: How disparities of two cameras are found.
        recording: Whose moments they are.
    """

    moments: Sequence[Moment]
    system: SensorSystem
    depth: PairDepth
    recording: Path = Path()

    def thresholds(self, path: Path, samples: Path) -> dict[str, str]:
        """Write a threshold table; moments that an earlier run measured are not measured again.

        Args:
            path: Of the table.
            samples: What is kept of each moment.

        Returns:
            Which moments were left out, when it was made, and why.

        Raises:
            ConfigurationError: All of them are broken.
            DataError: The file is broken, or cannot be written.
        """
        from avsec_gym.validation.thresholds import (
            ThresholdTable,
            read_threshold_table,
            shares_of,
        )

        if path.exists():
            return dict(read_threshold_table(path).on.data.get("left_out", {}))
        kept = self._measured(
            samples,
            "measuring clean moments",
            lambda _, frame: shares_of(frame, self.system, self.depth),
        )
        ThresholdTable(kept.on, kept.values).write(path)
        return kept.left_out

    def likelihood(self, path: Path, samples: Path, seed: int) -> dict[str, str]:
        """Write a likelihood model; moments that an earlier run attacked are not attacked again.

        Args:
            path: Of the model.
            samples: What is kept of each moment.
            seed: Of the attacks.

        Returns:
            As `thresholds`.

        Raises:
            ConfigurationError: Fewer than ten of them are whole.
            DataError: A file is broken, or cannot be written.
        """
        from avsec_gym.validation.likelihood.likelihood_of_clean import (
            evidence_of_all_states,
            likelihood_of_clean,
        )
        from avsec_gym.validation.likelihood.maximum_likelihood import read_likelihood_model

        if path.exists():
            return dict(read_likelihood_model(path).on.data.get("left_out", {}))
        kept = self._measured(
            samples,
            "attacking clean moments",
            lambda number, frame: evidence_of_all_states(
                frame, self.system, self.depth, (seed, number)
            ),
        )
        console.say(f"avsec: fitting the likelihood of {len(kept.whole)} moments")
        drives = [moment.drive or moment.id for moment in kept.whole]
        likelihood_of_clean(kept.on, kept.values, drives).write(path)
        return kept.left_out

    def _measured(
        self, samples: Path, what: str, measure: Callable[[int, SensorFrame], Floats]
    ) -> _Measured:
        """Measure what an earlier run did not, and keep it.

        Args:
            samples: A line for each moment.
            what: Is done with them.
            measure: Of a moment's number and frame.
        """
        from avsec_gym.storage.json_lines import JsonLines
        from avsec_gym.validation.fitted_on import fitted_on

        kept, left_out = JsonLines(samples), dict[str, str]()
        number = {moment.id: n for n, moment in enumerate(self.moments)}
        left = [moment for moment in self.moments if moment.id not in kept.rows]
        for moment, frame in readable(left, self.system, what, left_out):
            try:
                measured = measure(number[moment.id], frame)
            except DataError as error:
                left_out[moment.id] = str(error)
            else:
                kept.add({"id": moment.id, "measured": measured.tolist()})
        whole = [moment for moment in self.moments if moment.id in kept.rows]
        if not whole:
            reason = next(iter(left_out.values()), "")
            raise ConfigurationError(f"there are no clean moments to fit on: {reason}")
        calibration = whole[0].frame().calibration
        on = fitted_on(self.system, self.depth, calibration, self._data(left_out))
        values = np.array([kept.rows[moment.id]["measured"] for moment in whole])
        return _Measured(whole, values, on, left_out)

    def _data(self, left_out: dict[str, str]) -> dict[str, Any]:
        return {
            "recording": self.recording.name,
            "root": str(self.recording.resolve()),
            "first": _full_id(self.moments[0]),
            "last": _full_id(self.moments[-1]),
            "moments": len(self.moments) - len(left_out),
            "left_out": left_out,
        }


class _Measured(NamedTuple):
    """What is known of the moments that are whole."""

    whole: list[Moment]
    values: Floats
    """A row for each."""
    on: FittedOn
    left_out: dict[str, str]


def fitted_among(data: Mapping[str, Any], root: Path, moments: Sequence[Moment]) -> int:
    """How many of some moments a file was fitted on, in a drive or in the day that it is of.

    Args:
        data: What the file says of its data; of an earlier version, which names no root, nothing
            is known.
        root: Whose moments these are.
        moments: To be judged.
    """
    if "root" not in data:
        return 0
    first, second = Path(data["root"]), root.resolve()
    if first not in (second, *second.parents) and second not in first.parents:
        return 0
    return sum(data["first"] <= _full_id(moment) <= data["last"] for moment in moments)


def _full_id(moment: Moment) -> str:
    """With the drive's name, also where there is but one."""
    if moment.drive is None or "/" in moment.id:
        return moment.id
    return f"{moment.drive}/{moment.id}"


def readable(
    moments: Sequence[Moment], system: SensorSystem, what: str, left_out: dict[str, str]
) -> Iterator[tuple[Moment, SensorFrame]]:
    """Read one after the other, with progress.

    Args:
        moments: Of a recording.
        system: The sensors.
        what: Is done with them.
        left_out: Is told by their ids why some of them cannot be read.
    """
    with console.progress(what) as shown:
        for done, moment in enumerate(moments, start=1):
            try:
                frame = moment.frame()
                for camera in system.cameras:
                    frame.image(camera)
                if system.has_lidar:
                    _ = frame.points
            except DataError as error:
                left_out[moment.id] = str(error)
            else:
                yield moment, frame
            shown(done, len(moments))
