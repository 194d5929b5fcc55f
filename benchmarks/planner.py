"""Our planner and commonroad-search on the same files and primitives, in one run.

    python benchmarks/planner.py --scenarios DIR --primitives XML [--pattern GLOB]
        [--original PATH] [--repeat N]

``--original`` names a checkout of commonroad-search: the folder that holds ``SMP``.  Without it
only ours is measured.  Prints a table on the error stream and JSON on the output.  What is timed is
the search alone, in CPU time, on a scenario that is read and prepared: for the original
``execute_search`` with drawing switched off, for ours ``plan`` with everything it does.  Both sides
search each file equally often, and the best of each counts.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import io
import json
import signal
import statistics
import sys
import time
import types
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

ALGORITHMS = ("astar", "gbfs")
MANY = 40
"""Nodes of a search in which Python, and the handing of arrays to the kernel, are the lesser part
of the time."""
Row = dict[str, Any]
Side = Callable[[Path, str], Callable[[], Row]]
"""Prepares a search of a file by an algorithm, which can then be run again and again."""


def ours(primitives: Path) -> Side:
    """Plan with `MotionPrimitivePlanner`."""
    from avsec_gym.planners.collision import collision_world_of
    from avsec_gym.planners.planner import MotionPrimitivePlanner
    from avsec_gym.planners.primitive_files import read_primitives
    from avsec_gym.scenario.commonroad import read_commonroad

    loaded = read_primitives(primitives)

    def prepare(path: Path, algorithm: str) -> Callable[[], Row]:
        scenario = read_commonroad(path)
        world = collision_world_of(scenario, exact=True)
        planner = MotionPrimitivePlanner(algorithm, "reference", loaded, node_limit=20_000)
        planner.plan(scenario, world=world, explain=False)

        def run() -> Row:
            begun = time.thread_time()
            plan = planner.plan(scenario, world=world, explain=False)
            seconds = time.thread_time() - begun
            return {
                "status": plan.status.value,
                "cost": round(plan.cost, 6) if plan.found else None,
                "expanded": plan.expanded,
                "seconds": seconds,
            }

        return run

    return prepare


class TookTooLong(BaseException):
    """Not an Exception, so that nothing in between catches it."""


@contextlib.contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Interrupt what takes more CPU time (main thread, POSIX)."""

    def interrupt(*_: object) -> None:
        raise TookTooLong

    previous = signal.signal(signal.SIGPROF, interrupt)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, previous)


def stand_in_for_notebooks() -> None:
    """commonroad-search imports notebook widgets for its pictures; without them, empty modules."""

    def nothing(*_: object, **__: object) -> None:
        return None

    for name, members in (
        ("IPython", {}),
        ("IPython.display", {"display": nothing}),
        ("ipywidgets", {"widgets": types.ModuleType("ipywidgets")}),
    ):
        try:
            importlib.import_module(name)
        except ImportError:
            module = types.ModuleType(name)
            vars(module).update(members)
            sys.modules[name] = module
            if "." in name:
                setattr(sys.modules[name.split(".")[0]], name.split(".")[1], module)
    notebook: Any = types.ModuleType("tqdm.notebook")
    notebook.tqdm = lambda items, *_, **__: items
    sys.modules["tqdm.notebook"] = notebook


def original(checkout: Path, primitives: Path, limit: float) -> Side:
    """Plan with commonroad-search's own classes, drawing switched off."""
    sys.path.insert(0, str(checkout))
    stand_in_for_notebooks()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        automata: Any = importlib.import_module("SMP.maneuver_automaton.maneuver_automaton")
        searches: Any = importlib.import_module(
            "SMP.motion_planner.search_algorithms.best_first_search"
        )
        reader: Any = importlib.import_module("commonroad.common.file_reader")
        with contextlib.redirect_stdout(io.StringIO()):
            automaton = automata.ManeuverAutomaton.generate_automaton(str(primitives))
    searches.update_visualization = lambda **named: named["dict_node_status"]
    searches.initial_visualization = lambda *_, **__: None
    kinds = {"astar": searches.AStarSearch, "gbfs": searches.GreedyBestFirstSearch}

    def run(path: Path, algorithm: str) -> Row:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scenario, problems = reader.CommonRoadFileReader(str(path)).open()
            problem = next(iter(problems.planning_problem_dict.values()))
            planner = kinds[algorithm](scenario, problem, automaton)
        planner.plot_solution = lambda **named: named["list_states_nodes"]
        planner.plot_colliding_primitives = lambda **named: (
            named["list_states_nodes"],
            named["node_status"],
        )
        popped, pop = [0], planner.frontier.pop

        def counted() -> Any:
            popped[0] += 1
            return pop()

        planner.frontier.pop = counted
        begun = time.thread_time()
        try:
            with at_most(limit):
                path_found, *_ = planner.execute_search()
        except TookTooLong:
            return {"status": "timeout", "cost": None, "expanded": popped[0], "seconds": limit}
        seconds = time.thread_time() - begun
        found = path_found is not None
        cost = None
        if found:
            steps = path_found[-1][-1].time_step - path_found[0][0].time_step
            cost = round(steps * scenario.dt, 6)
        return {
            "status": "found" if found else "exhausted",
            "cost": cost,
            "expanded": popped[0] - found,
            "seconds": seconds,
        }

    return lambda path, algorithm: lambda: run(path, algorithm)


def best_of(search: Callable[[], Row], repeat: int) -> Row:
    """The fastest of some runs; one that took too long is not tried again."""
    best = search()
    for _ in range(repeat - 1):
        if best["status"] != "timeout":
            best = min(best, search(), key=lambda row: float(row["seconds"]))
    return best


def speed_ratio(rows: list[Row]) -> float:
    """As many times as long the original takes for all of them together."""
    original, ours = (sum(row[side]["seconds"] for row in rows) for side in ("original", "ours"))
    return float(original / ours)


def summary(rows: list[Row]) -> Row:
    """Totals over the rows that both finished; without the original, over those that ended."""
    both = [r for r in rows if "original" in r and r["original"]["status"] != "timeout"]
    ended = both or [r for r in rows if r["ours"]["status"] != "limit"]
    sides = [name for name in ("ours", "original") if name in ended[0]]
    total = {name: sum(row[name]["seconds"] for row in ended) for name in sides}
    nodes = sum(r["ours"]["expanded"] for r in ended)
    result: Row = {
        "rows": len(rows),
        "nodes": nodes,
        "ours_seconds_total": total["ours"],
        "ours_seconds_median": statistics.median(r["ours"]["seconds"] for r in rows),
        "ours_microseconds_a_node": 1e6 * total["ours"] / nodes,
    }
    if not both:
        return result
    same = [
        all(r["ours"][key] == r["original"][key] for key in ("status", "cost", "expanded"))
        for r in both
    ]
    ratios = [r["original"]["seconds"] / r["ours"]["seconds"] for r in both]
    long = [r for r in both if r["ours"]["expanded"] >= MANY]
    return result | {
        "compared": len(both),
        "same_nodes_and_cost": sum(same),
        "original_timeouts": sum(r.get("original", {}).get("status") == "timeout" for r in rows),
        "original_seconds_total": total["original"],
        "original_microseconds_a_node": 1e6 * total["original"] / nodes,
        "speed_ratio_median": statistics.median(ratios),
        "speed_ratio_total": speed_ratio(both),
        "many_nodes": MANY,
        "rows_of_many_nodes": len(long),
        "speed_ratio_of_many_nodes": speed_ratio(long) if long else None,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--scenarios", type=Path, required=True, help="folder of CommonRoad files")
    parser.add_argument("--primitives", type=Path, required=True, help="motion primitives, XML")
    parser.add_argument("--pattern", default="*.xml", help="which files (default %(default)s)")
    parser.add_argument("--original", type=Path, help="checkout of commonroad-search")
    parser.add_argument("--limit", type=float, default=10.0, help="CPU seconds for the original")
    parser.add_argument("--repeat", type=int, default=3, help="runs of each side, best counts")
    arguments = parser.parse_args()
    files = sorted(arguments.scenarios.glob(arguments.pattern))
    if not files:
        parser.error(f"no {arguments.pattern} in {arguments.scenarios}")
    planners = {"ours": ours(arguments.primitives)}
    if arguments.original is not None:
        planners["original"] = original(
            arguments.original, arguments.primitives.resolve(), arguments.limit
        )
    rows: list[Row] = []
    for path in files:
        for algorithm in ALGORITHMS:
            row: Row = {"file": path.name, "planner": algorithm}
            for name, prepare in planners.items():
                row[name] = best_of(prepare(path, algorithm), arguments.repeat)
            rows.append(row)
            cells = [
                f"{name} {row[name]['status']:9} {row[name]['expanded']:6d} nodes"
                f" {row[name]['seconds'] * 1e3:9.3f} ms"
                for name in planners
            ]
            print(f"{path.name:28} {algorithm:5}  " + "   ".join(cells), file=sys.stderr)
    print(json.dumps({"summary": summary(rows), "rows": rows}, indent=1))


if __name__ == "__main__":
    main()
