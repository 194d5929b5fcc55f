"""The leaderboard's table of results on KITTI's own frames."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.benchmark.entry import Entry, EntryRow
from avsec_gym.benchmark.kitti_scenes import KITTI, KITTI_CONTESTED
from avsec_gym.benchmark.leaderboard_cells import entry_cell, estimate_cell
from avsec_gym.benchmark.protocol import UNATTACKED
from avsec_gym.drawing.page_table import Table, TableCell, figure

_RATES = {
    "success": "success_rate",
    "collision": "collision_rate",
    "safe driving": "safe_driving_rate",
}
_NOTE = (
    "On the 600 labelled scenarios of real KITTI, which are read where the user has them; no frame "
    "is attacked, so nothing is said of a broken entry, or of what an attacker knows. The three "
    "rates in percent, over all driving intentions; collisions are a share of the planned "
    "trajectories. Change: of the safe driving rate, beside the same drives by the truth, in "
    "points. AP: average precision of moderate cars in 3D, 11 recall points; the ceiling is what "
    "perfect detections of so many labels reach. Contested: scenes and intentions that a blind car "
    "drives unsafely, and one that sees all drives safely. In brackets 95 % intervals, over scenes "
    "of the rates and over frames of the precision."
)


def kitti_table(entries: Sequence[Entry]) -> Table:
    """A row for each entry, the safest on contested scenes first.

    Args:
        entries: Entries with rows of the labelled KITTI scenarios.
    """
    columns = ["detector"]
    for scenes in ("all", "contested"):
        columns += [f"{rate}, {scenes}" for rate in (*_RATES, "change")]
        columns += [f"{what}, {scenes}" for what in ("AP .7", "AP .5", "ceiling")]
    return Table(
        "Results on KITTI's own frames, the safest to drive by on contested scenes first",
        columns,
        [_cells(entry) for entry in sorted(entries, key=_safest_first)],
        _NOTE,
        sortable=True,
    )


def has_kitti(entry: Entry) -> bool:
    """Whether an entry was driven in the labelled KITTI scenarios."""
    return entry.row(KITTI, UNATTACKED) is not None


def _safest_first(entry: Entry) -> tuple[float, str]:
    row = entry.row(KITTI_CONTESTED, UNATTACKED)
    return (0.0 if row is None else -row.rates.safe_driving_rate), entry.name


def _cells(entry: Entry) -> list[TableCell]:
    rows = [entry.row(scenes, UNATTACKED) for scenes in (KITTI, KITTI_CONTESTED)]
    return [entry_cell(entry), *(cell for row in rows for cell in _of_scenes(row))]


def _of_scenes(row: EntryRow | None) -> list[TableCell]:
    """What is shown of a set of scenes."""
    if row is None:
        return [figure(None)] * (len(_RATES) + 4)
    rates, episodes = row.rates.to_json(), f"{row.rates.scenarios} drives"
    cells = [
        figure(rates[name], rates[f"{name}_interval"], scale=100, hint=episodes)
        for name in _RATES.values()
    ]
    cells.append(
        figure(None)
        if row.paired is None
        else estimate_cell(row.paired.safe_driving_rate, scale=100, signed=True)
    )
    precision = row.precision
    if precision is None:
        return [*cells, *[figure(None)] * 3]
    labels = f"{precision.labels} labels"
    return [
        *cells,
        estimate_cell(precision.strict, hint=labels),
        estimate_cell(precision.loose, hint=labels),
        figure(precision.ceiling, hint=labels),
    ]
