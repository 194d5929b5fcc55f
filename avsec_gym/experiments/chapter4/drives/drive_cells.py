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
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    CLEAN,
    FITTED,
    JUDGED,
    USUAL,
    Part,
    State,
)
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
from avsec_gym.validation.connected.result import AttackKind, ConnectedResult
from avsec_gym.validation.connected.validator import ConnectedValidator

USUAL_DRIVES = 3000
_WORK = f"{__name__}:ConnectedDrives"
_FORMAT = 3
"""Raised when what is measured changes, so that cells are done again."""
_MOST_WINDOWS = 100
_MOST_DRIVES = 100_000
_ATTACKS: dict[AttackKind, LastingAttack] = {"ghost": MovingGhost(), "removal": LastingRemoval()}


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
    apart = _whole(configuration, "apart", WINDOW)
    attacked = _whole(configuration, "attacked", _MOST_DRIVES)
    cells = []
    for number in range(configuration.limit or USUAL_DRIVES):
        is_attacked = number < attacked
        if is_attacked:
            cells.append(_cell(FITTED, number, 1, WINDOW, True))
        cells.append(_cell(JUDGED, number, windows, apart, is_attacked))
    return cells


def _cell(part: Part, number: int, windows: int, apart: int, attacked: bool) -> Cell:
    return Cell.of(
        _WORK,
        f"{part} {number}",
        part=part,
        number=number,
        windows=windows,
        apart=apart,
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
        self, part: Part, number: int, windows: int, apart: int, attacked: bool, format: int
    ) -> CellResult:
        """The windows of a drive.

        Args:
            part: `FITTED` or `JUDGED`.
            number: Number of the drive.
            windows: Number of its windows.
            apart: Instants from the beginning of a window to that of the next.
            attacked: Whether the first window is attacked, too, once by each attack.
            format: Format of what is measured; cells of another one are done again.
        """
        rows: list[Measurement] = []
        results: list[ConnectedResult] = []
        seconds = {"scan": 0.0, "judge": 0.0}
        begin = time.perf_counter()
        drive = scanned_drive(self._seed, part, number, (windows - 1) * apart + WINDOW)
        while instants := list(islice(drive, WINDOW)):
            scanned = time.perf_counter()
            # Each instant is judged once, however many windows it is in.
            first = not results
            results += [self._judged(instant) for instant in instants]
            for kind in ATTACKS if attacked and first else ():
                rows += self._attacked_rows(part, kind, number, instants)
            judged = time.perf_counter()
            seconds["scan"] += scanned - begin
            seconds["judge"] += judged - scanned
            begin = judged
        for window in range(windows):
            of_window = results[window * apart :][:WINDOW]
            rows += self._rows(part, CLEAN, number, window, of_window)
        return CellResult(measurements=rows, seconds=seconds)

    def _attacked_rows(
        self, part: Part, kind: AttackKind, number: int, instants: Sequence[RecordedInstant]
    ) -> list[Measurement]:
        """The rows of a window under an attack; none where there is nothing to attack."""
        seed = (self._seed, number, STATES.index(kind))
        attacks = list(_attacked(_ATTACKS[kind], instants, seed))
        if not attacks:
            return []
        results = [self._judged(attack.instant) for attack in attacks]
        return self._rows(part, kind, number, 0, results, attacks)

    def _rows(
        self,
        part: Part,
        state: State,
        number: int,
        window: int,
        results: Sequence[ConnectedResult],
        attacks: Sequence[AttackedInstant] = (),
    ) -> list[Measurement]:
        """The rows of a window in a state."""
        measured = measured_window(
            f"{number:06d}",
            results,
            attacks,
            self._constants.rates,
            # The correlation of frames is fitted on all tracks, quiet ones too.
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
