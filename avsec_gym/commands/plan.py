"""`avsec plan`: plans CommonRoad files."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from avsec_gym import console
from avsec_gym.errors import AvsecError, ConfigurationError, DataError, PlanningError
from avsec_gym.storage.regular_files import is_folder, is_there

if TYPE_CHECKING:
    from avsec_gym.planners.plan import Plan
    from avsec_gym.planners.planner import Planner
    from avsec_gym.scenario.planning_scenario import PlanningScenario


@dataclass(frozen=True)
class PlanFiles:
    """Plan CommonRoad files: a trajectory, or the reason why there is none."""

    files: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """CommonRoad XML files, or folders of them."""
    primitives: Path | None = None
    """Motion primitives in CommonRoad's XML format; default: generated for each file."""
    planner: str = "astar"
    """astar, gbfs (greedy best-first search), a plug-in's planner by its name; or JSON with
    arguments, which take the place of the options below."""
    mode: Literal["complete", "reference"] = "complete"
    """complete: always ends, with a certificate; reference: commonroad-search's search, node for
    node."""
    node_limit: int = 100_000
    """Most nodes to expand for a file. A search whose nodes would take more than half of the
    machine's memory ends as at a limit (reason: memory)."""
    time_limit: float = 30.0
    """Most seconds for a file."""
    pictures: Path | None = None
    """Folder for a PNG of each file."""
    overwrite: bool = False
    """Replace pictures that are there."""
    json: bool = False
    """A JSON line for each file: file, status, found, cost (s), expanded, seconds without
    loading."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.scenario.commonroad import read_commonroad

        if self.node_limit < 1 or not self.time_limit > 0:
            raise ConfigurationError("--node-limit and --time-limit are above 0")
        files = _expand(self.files)
        self._check_pictures(files)
        planner = self._planner()
        rows, skipped, warm = [], 0, self.pictures is None
        with console.progress("planning") as shown:
            for number, file in enumerate(files, start=1):
                try:
                    scenario = read_commonroad(file)
                    if not warm:
                        # The kernels of a search are loaded before its clock runs, those of the
                        # tree that a picture shows are not.
                        planner.plan(scenario)
                        warm = True
                    plan = planner.plan(scenario)
                except AvsecError as raised:
                    error = _with_file(raised, file)
                    skipped += 1
                    console.complain(error)
                    row = {
                        "file": file.name,
                        "status": "error",
                        "found": False,
                        "cost": None,
                        "expanded": None,
                        "seconds": None,
                        "error": str(error),
                    }
                else:
                    row = _row(file, plan)
                    if self.pictures is not None:
                        _draw(scenario, plan, self.pictures / f"{file.stem}.png", self.overwrite)
                rows.append(row)
                if self.json:
                    console.print_json_line("plan", row)
                shown(number, len(files))
        if not self.json:
            console.print_table(f"{self.planner}, {self.mode}", _COLUMNS, [_cells(r) for r in rows])
        if skipped == len(files):
            return console.BAD_DATA
        return console.DONE_IN_PART if skipped else console.DONE

    def _planner(self) -> Planner:
        """With the limits and primitives that were asked for, if it is one of the package's.

        Raises:
            ConfigurationError: There is none of that name, or it cannot take an option.
        """
        from avsec_gym.commands.named_planner import named_planner
        from avsec_gym.planners.kept_tree import with_tree
        from avsec_gym.planners.planner import Algorithm, Mode, MotionPrimitivePlanner
        from avsec_gym.planners.primitive_files import read_primitives

        planner: Planner
        if self.planner in list(Algorithm):
            planner = MotionPrimitivePlanner(
                Algorithm(self.planner),
                Mode(self.mode),
                None if self.primitives is None else read_primitives(self.primitives),
                self.node_limit,
                self.time_limit,
            )
        else:
            name, planner = named_planner(self.planner)
            usual = PlanFiles(())
            for option in ("primitives", "mode", "node_limit", "time_limit"):
                if getattr(self, option) != getattr(usual, option):
                    flag = option.replace("_", "-")
                    raise ConfigurationError(
                        f"--{flag} belongs to --planner {' and '.join(Algorithm)}; {name} takes its"
                        """ arguments as JSON, --planner '{"name": ..., ...}'"""
                    )
        return planner if self.pictures is None else with_tree(planner)

    def _check_pictures(self, files: list[Path]) -> None:
        """Refuse to lose a picture before anything is planned."""
        if self.pictures is None:
            return
        names = [self.pictures / f"{file.stem}.png" for file in files]
        if len(set(names)) < len(names):
            raise ConfigurationError("two files have one name, and so would their pictures")
        for name in names:
            if is_there(name) and not self.overwrite:
                raise DataError(
                    "the picture exists.", path=name, remedy="Name another folder, or --overwrite."
                )


_COLUMNS = ["file", "status", "cost [s]", "expanded", "time [ms]", "why not"]


def _row(file: Path, plan: Plan) -> dict[str, Any]:
    return {
        "file": file.name,
        "status": str(plan.status),
        "found": plan.found,
        # Sums of time steps, without the noise of adding tenths.
        "cost": round(plan.cost, 9) if plan.found else None,
        "expanded": plan.expanded,
        "start_speed": None if math.isnan(plan.start_speed) else plan.start_speed,
        "seconds": plan.seconds,
        "reason": None if plan.reason is None else str(plan.reason),
        # A planner of another package may not report it.
        "goal_occupied": None if math.isnan(plan.goal_occupied) else plan.goal_occupied,
        "lower_bound": None if math.isnan(plan.lower_bound) else round(plan.lower_bound, 9),
    }


def _cells(row: dict[str, Any]) -> list[str]:
    if row["status"] == "error":
        return [row["file"], "error", "–", "–", "–", row["error"]]
    return [
        row["file"],
        row["status"],
        "–" if row["cost"] is None else f"{row['cost']:.1f}",
        str(row["expanded"]),
        f"{1000 * row['seconds']:.2f}",
        row["reason"] or "",
    ]


def _with_file(error: AvsecError, file: Path) -> AvsecError:
    """The error of planning with the file that it is of; others name theirs."""
    return DataError(f"{error}.", path=file) if isinstance(error, PlanningError) else error


def _expand(files: tuple[Path, ...]) -> list[Path]:
    found: list[Path] = []
    for file in files:
        found += sorted(file.glob("*.xml")) if is_folder(file) else [file]
    if not files:
        raise ConfigurationError(
            "name at least one CommonRoad XML file, or a folder that holds one"
        )
    if not found:
        raise DataError(
            "There is no CommonRoad XML file here.",
            path=files[0],
            remedy="Name a folder that holds some, directly in it.",
        )
    return found


def _draw(scenario: PlanningScenario, plan: Plan, path: Path, overwrite: bool) -> None:
    from avsec_gym.drawing.scenario_picture import draw_episode, save_picture
    from avsec_gym.metrics.safety import judge
    from avsec_gym.pipeline import Episode

    record = judge(plan, scenario, scenario.obstacles)
    episode = Episode(scenario, plan, scenario.obstacles, record)
    save_picture(draw_episode(episode), path, overwrite=overwrite)
