"""`avsec demo`: the main job on the procedural world, end to end, from nothing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from avsec_gym import console
from avsec_gym.argument_checks import whole_number
from avsec_gym.commands.report import PAGE, Report
from avsec_gym.commands.run import Run
from avsec_gym.errors import AvsecError
from avsec_gym.storage.regular_files import is_file, read_text

if TYPE_CHECKING:
    from avsec_gym.experiments.demo.story import StoryRow

_NAME = "demo"
_FIRST_LOOK = "avsec demo, at its beginning"
"""What its page names as its maker."""
_LOOK_AGAIN = "\nsetTimeout(() => location.reload(), 15000);\n"
"""What has that page read again what was written meanwhile."""
_PICTURES = 4
_FEW = 8
"""The most scenes that are rendered before the drives, in the process that makes these."""


@dataclass(frozen=True)
class Demo:
    """Attack two detectors where something is in the way: what do they see, how does the car drive?

    Renders stereo pairs of streets and highways into the user's cache, once, in which a car that
    sees nothing would drive unsafely; lets DSGN and Stereo R-CNN look at them unattacked, under the
    thesis' PGD and with a patch in the view; drives left, straight and right by what they believe;
    and writes a page with pictures and tables. A demo that was stopped goes on when the command is
    given again.
    """

    out: Path = Path("runs/demo")
    """Folder of the run: new, empty, or with the same demo."""
    scenarios: int = 3
    """How many scenes, each driven left, straight and right."""
    seed: int = 0
    """Seed of the scenes and the attacks."""
    workers: int | None = None
    """Number of processes.  Default: one for each core, up to four."""
    json: bool = False
    """Print JSON instead of a table."""

    def run(self) -> int:
        """Do it; the exit code: 3 where something failed."""
        from avsec_gym.experiments.demo.contested_frames import contested_frames
        from avsec_gym.experiments.demo.drive_ahead import drives_ahead
        from avsec_gym.experiments.demo.drive_on import FOLDER as DRIVES
        from avsec_gym.experiments.demo.drive_on import drive_on
        from avsec_gym.experiments.demo.experiment import unpatched
        from avsec_gym.experiments.demo.quick_compilation import quick_compilation
        from avsec_gym.experiments.demo.story import StoryRow
        from avsec_gym.experiments.json_rows import row_of
        from avsec_gym.experiments.procedural_frames import CONTESTED
        from avsec_gym.runs.run_folder import RunFolder
        from avsec_gym.world.export import MOST_FRAMES

        whole_number("--scenarios", self.scenarios, 1, MOST_FRAMES)
        whole_number("--seed", self.seed, 0)
        if self.workers is not None:
            whole_number("--workers", self.workers, 0)
        # Both detectors under attack; what is rendered beside that, where it takes as long.
        drives, is_new = self.out / DRIVES, self._is_new()
        beside = is_new and self._jobs > 1 and self.scenarios <= _FEW
        # One process is this very one, which needs no time to begin.
        others, threads = (self._jobs - 1, 1) if beside else (self.workers, None)
        others = 0 if others == 1 else others
        asked = Run(
            (_NAME,), CONTESTED, self.scenarios, self.seed,
            out=self.out, workers=others, threads=threads,
        )  # fmt: skip
        processes = self._jobs if beside else 1
        with (
            quick_compilation(),
            drives_ahead(drives, self.scenarios, self.seed, processes) as ahead,
        ):
            if is_new:
                self._look_first()
            last = None
            if beside:
                with console.progress("driving on") as shown:
                    last = ahead.drive_beside(shown)
                with console.progress("rendering") as shown:
                    ahead.wait_for_frames(shown)
                contested_frames(self.scenarios, self.seed, self._jobs - 1)
            ran = asked.ran(_FirstScene(self.out, self.scenarios), (PAGE, DRIVES) if is_new else ())
            # Its episodes on the page, before the drives are done.
            folder, page = RunFolder.open(self.out), Report(self.out, pictures=_PICTURES)
            for detector in unpatched(folder.configuration.options):
                console.say(f"avsec: no patch against {detector}: there is no trained one here")
            if ahead.is_busy():
                page.written()
                console.say(f"{self.out / PAGE}: the episodes in pictures; drives follow")
            with console.progress("driving on") as shown:
                ahead.wait_for_drives(shown)
        with console.progress("driving on") as shown:
            drive_on(drives, self.seed, self._jobs, shown, control=self._is_report, last=last)
        # The page with the drives, what was seen in sentences, and its figures.
        report, reported = page.written()
        for sentence in report.sentences:
            console.say(sentence)
        figures = {name: report.data.get(name, []) for name in ("story", "rates", "drives")}
        if self.json:
            console.print_json("demo", {"out": str(self.out), **figures})
        else:
            _print([row_of(StoryRow, columns) for columns in figures["story"]])
        console.say(f"{self.out / PAGE}: the episodes in pictures")
        return max(ran, reported)

    @property
    def _jobs(self) -> int:
        """Processes that work at a time."""
        from avsec_gym.runs.run import usable_cores
        from avsec_gym.runs.shares import usual_workers

        usual = usual_workers([usable_cores()], threads=1)
        return max(usual if self.workers is None else self.workers, 1)

    @property
    def _is_report(self) -> bool:
        """Whether there are scenes enough for a report."""
        from avsec_gym.experiments.demo.experiment import FULL_REPORT

        return self.scenarios >= FULL_REPORT

    def _is_new(self) -> bool:
        """Whether there is no run yet: nothing, or what a demo that was stopped had begun with."""
        from avsec_gym.experiments.demo.drive_on import FOLDER, are_demo_drives
        from avsec_gym.storage.folders import make_folder

        make_folder(self.out)
        there = [path for path in self.out.iterdir() if not path.name.startswith(".")]
        return all(
            _is_first_look(path)
            or (path.name == FOLDER and are_demo_drives(path, self.seed, control=self._is_report))
            for path in there
        )

    def _look_first(self) -> None:
        """Write a page of what the demo is about."""
        from avsec_gym.experiments.chapter5.section.sections import style_and_script
        from avsec_gym.experiments.demo.first_look import TITLE, first_look
        from avsec_gym.report.plain_page import plain_page
        from avsec_gym.storage.text_files import write_text

        style, script = style_and_script()
        text = plain_page(TITLE, _FIRST_LOOK, [first_look(self.seed)], style, script + _LOOK_AGAIN)
        write_text(self.out / PAGE, text, overwrite=True)
        console.say(f"{self.out / PAGE}: what it is about, in a picture; then come the attacks")


def _is_first_look(path: Path) -> bool:
    return path.name == PAGE and is_file(path) and f'"{_FIRST_LOOK}"' in read_text(path)


class _FirstScene:
    """Writes the page as soon as one scene of several is done, with a picture of it.

    Args:
        out: Folder of the run.
        scenarios: Number of scenes.
    """

    def __init__(self, out: Path, scenarios: int) -> None:
        self._out, self._scenarios = out, scenarios
        self._waits = scenarios > 1

    def __call__(self, done: int, total: int) -> None:
        """So many cells of so many are done; each scene has as many as another."""
        of_one = total // self._scenarios
        if not self._waits or not of_one <= done < total:
            return
        from avsec_gym.runs.run_folder import RunFolder

        cells = RunFolder.open(self._out).cells()
        finished = Counter(cell.arguments["scenario"] for cell in cells)
        if max(finished.values()) == of_one:
            self._waits = False
            # The page at the end reports what is wrong; the run is worth more than this one.
            with suppress(AvsecError):
                Report(self._out, pictures=1).written(quietly=True)
                console.say(f"{self._out / PAGE}: the first scene in a picture; others follow")


def _print(rows: Sequence[StoryRow]) -> None:
    """Cars that each detector found, and episodes that stayed safe, before an attack and after."""
    from avsec_gym.experiments.chapter5.attack_names import detector_name
    from avsec_gym.experiments.chapter5.settings import UNATTACKED

    before = {row.detector: row for row in rows if row.attack == UNATTACKED}
    attacked = [row for row in rows if row.attack != UNATTACKED and row.detector in before]
    if not attacked:
        return
    console.print_table(
        f"{attacked[0].cars} cars, and {attacked[0].episodes} episodes with something in the way",
        ["detector", "attack", "found before", "found after", "safe before", "safe after"],
        [
            [
                detector_name(row.detector),
                row.name,
                str(before[row.detector].found),
                str(row.found),
                str(before[row.detector].safe),
                str(row.safe),
            ]
            for row in attacked
        ],
    )
