"""The work of the experiment on drives: windows, attack-free and under attacks that last."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter4.drives.measured_window import measured_window, rows_of
from avsec_gym.experiments.chapter4.drives.scanned_drives import scanned_drive
from avsec_gym.experiments.chapter4.drives.settings import OPTIONS, STATES, WINDOW
from avsec_gym.experiments.chapter4.instant_cells import constants_under
from avsec_gym.experiments.chapter4.settings import CLEAN, FITTED, JUDGED, USUAL, Part, State
from avsec_gym.experiments.procedural_frames import PROCEDURAL
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, Measurement
from avsec_gym.validation.connected.attacks.attacked_instant import (
    AttackedInstant,
    LastingAttack,
)
from avsec_gym.validation.connected.attacks.lasting_removal import LastingRemoval
from avsec_gym.validation.connected.attacks.moving_ghost import MovingGhost
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.proposals.remembered import RememberedProposals
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.validator import ConnectedValidator

USUAL_DRIVES = 3000
_WORK = f"{__name__}:ConnectedDrives"
_FORMAT = 2
"""Raised when what is measured changes, so that cells are done again."""
_MOST_WINDOWS = 100
_MOST_DRIVES = 100_000
_ATTACKS: dict[State, LastingAttack] = {"ghost": MovingGhost(), "removal": LastingRemoval()}


def drive_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every drive; drives to fit on and to judge take turns as long as there are both.

    Raises:
        ConfigurationError: Data other than procedural ones, or no such numbers.
    """
    if configuration.scenarios != PROCEDURAL:
        raise ConfigurationError(
            f"chapter4_drives judges drives of the procedural world: --scenarios is {PROCEDURAL!r},"
            f" got {configuration.scenarios!r}; `avsec connected --sequence {WINDOW} --data` judges"
            " other data"
        )
    if not 0 <= configuration.seed < 1000:
        raise ConfigurationError(f"a seed of drives is from 0 to 999, got {configuration.seed}")
    windows = _whole(configuration, "windows", _MOST_WINDOWS)
    attacked = _whole(configuration, "attacked", _MOST_DRIVES)
    cells = []
    for number in range(configuration.limit or USUAL_DRIVES):
        is_attacked = number < attacked
        if is_attacked:
            cells.append(_cell(FITTED, number, 1, True))
        cells.append(_cell(JUDGED, number, windows, is_attacked))
    return cells


def _cell(part: Part, number: int, windows: int, attacked: bool) -> Cell:
    return Cell.of(
        _WORK,
        f"{part} {number}",
        part=part,
        number=number,
        windows=windows,
        attacked=attacked,
        format=_FORMAT,
    )


def _whole(configuration: Configuration, option: str, most: int) -> int:
    value = {**OPTIONS, **configuration.options}[option]
    if type(value) is not int or not 1 <= value <= most:
        raise ConfigurationError(f"{option} are 1 to {most}, got {value!r}")
    return value


def drive_inputs(configuration: Configuration) -> dict[str, Path]:
    """The fit that constants come from."""
    given = {**OPTIONS, **configuration.options}
    return {"constants": Path(given["constants"] or SHIPPED_FIT)}


class ConnectedDrives:
    """Measures the windows of drives by evidence of rays.

    Args:
        configuration: The configuration of the run.

    Raises:
        DataError: The file of constants is missing or damaged.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._fit = read_connected_fit(drive_inputs(configuration)["constants"])
        self._constants = constants_under(self._fit, USUAL)
        self._proposer = RememberedProposals(_SCANS)
        self._validator = ConnectedValidator(self._constants, proposer=self._proposer)
        self._seed = configuration.seed

    def __call__(
        self, part: Part, number: int, windows: int, attacked: bool, format: int
    ) -> CellResult:
        """The windows of a drive.

        Args:
            part: `FITTED` or `JUDGED`.
            number: Number of the drive.
            windows: Number of its windows.
            attacked: Whether the first window is attacked, too, once by each attack.
            format: Format of what is measured; cells of another one are done again.
        """
        rows: list[Measurement] = []
        seconds = {"scan": 0.0, "judge": 0.0}
        begin = time.perf_counter()
        drive = scanned_drive(self._seed, part, number, windows * WINDOW)
        for window in range(windows):
            instants = list(islice(drive, WINDOW))
            scanned = time.perf_counter()
            for state in STATES if attacked and window == 0 else (CLEAN,):
                rows += self._rows(part, state, number, window, instants)
            judged = time.perf_counter()
            seconds["scan"] += scanned - begin
            seconds["judge"] += judged - scanned
            begin = judged
        return CellResult(measurements=rows, seconds=seconds)

    def _rows(
        self,
        part: Part,
        state: State,
        number: int,
        window: int,
        instants: Sequence[RecordedInstant],
    ) -> list[Measurement]:
        """The rows of a window in a state; none where there is nothing to attack."""
        attacks: list[AttackedInstant] = []
        given = list(instants)
        if state != CLEAN:
            seed = (self._seed, number, STATES.index(state))
            attacks = list(_attacked(_ATTACKS[state], instants, seed))
            given = [attack.instant for attack in attacks]
        if not given:
            return []
        results = [self._judged(instant) for instant in given]
        # The correlation of frames is fitted on all tracks, quiet ones too.
        measured = measured_window(
            f"{number:06d}",
            results,
            attacks,
            self._constants.rates,
            quiet=(part, state) == (FITTED, CLEAN),
        )
        return rows_of(measured, part, state, window)

    def _judged(self, instant: RecordedInstant) -> ConnectedResult:
        self._fit.check(instant.scans)
        return self._validator.validate(instant.scans, id=instant.id)


def _attacked(
    attack: LastingAttack, instants: Sequence[RecordedInstant], seed: tuple[int, ...]
) -> Iterator[AttackedInstant]:
    """The instants of an attack that begins with the first one, as long as it lasts."""
    begun = attack.begin(instants[0], seed)
    if begun is None:
        return
    for frame, instant in enumerate(instants):
        attacked = begun.attack(instant, attack.step * frame)
        if attacked is None:
            return
        yield attacked


_SCANS = len(STATES) * WINDOW * USUAL.vehicles
"""Scans of a window in all states."""
