"""`avsec report`: the results of a run, as one page with pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from avsec_gym import console
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.regular_files import is_there

if TYPE_CHECKING:
    from avsec_gym.report.run_report import RunReport

PAGE = "report.html"


@dataclass(frozen=True)
class Report:
    """Write one HTML page about a run, finished or not: the answer, tables, plots, pictures.

    The page needs no network and no other file. Pictures are of the most telling scenes, chosen by
    rules that the page states; the attacks on them are repeated, so the run's scenes and weights
    must be where they were.
    """

    run_folder: Annotated[Path, tyro.conf.Positional]
    """Folder that `avsec run` wrote."""
    out: Path | None = None
    """The page.  Default: report.html in the run's folder, which is written anew each time."""
    markdown: Path | None = None
    """Also write the main tables as Markdown into this file."""
    pictures: int = 8
    """Most scenes with pictures; 0: none, of feature maps and repairs neither.  Each takes two
    attacks or three, of repairs one."""
    looked_at: int = 0
    """How many, in `identification`, of the judged frames, the first ones, were looked at while a
    method was made; its rates are also given without them."""
    experiments: tuple[str, ...] = ()
    """Experiments that `avsec experiments` does not list and whose sections the page shows, such as
    my_package.my_module:MY_EXPERIMENT.  Nothing that only the run's folder names is imported."""
    overwrite: bool = False
    """Write over files that --out and --markdown name."""
    json: bool = False
    """Print all figures as JSON."""

    def run(self) -> int:
        """Do it; the exit code: 3 where pictures could not be made."""
        report, code = self.written()
        if self.json:
            console.print_json("report", report.data)
        console.say(self.sentence(report))
        return code

    def written(self, *, quietly: bool = False) -> tuple[RunReport, int]:
        """Write the page; what is on it, and the exit code.

        Args:
            quietly: Whether remarks and progress are left out.
        """
        from avsec_gym.report.html import html_page
        from avsec_gym.report.run_markdown import markdown_page
        from avsec_gym.report.run_remarks import remarks
        from avsec_gym.report.run_report import run_report
        from avsec_gym.runs.run_folder import RunFolder
        from avsec_gym.runs.section import ReportRequest
        from avsec_gym.storage.text_files import write_text

        if self.pictures < 0:
            raise ConfigurationError(f"--pictures is 0 or more, got {self.pictures}")
        if self.looked_at < 0:
            raise ConfigurationError(f"--looked-at is 0 or more, got {self.looked_at}")
        folder = RunFolder.open(self.run_folder)
        for path in (self.out, self.markdown):
            if path is not None and is_there(path) and not self.overwrite:
                raise DataError(
                    "the file exists.", path=path, remedy="Name another, or use --overwrite."
                )
        # With --out, nothing is written into the run's folder.
        keeps = self.out is None
        asked = ReportRequest(self.pictures, self.looked_at, keeps, self.experiments)
        if not quietly:
            asked = replace(asked, progress=console.progress)
        report = run_report(folder, asked)
        for remark in () if quietly else (*remarks(report), *report.problems):
            console.say(f"avsec: {remark}")
        write_text(self._page, html_page(report), overwrite=True)
        if self.markdown is not None:
            write_text(self.markdown, markdown_page(report), overwrite=True)
        return report, console.DONE_IN_PART if report.problems else console.DONE

    def sentence(self, report: RunReport) -> str:
        """Where the page is, and its answer."""
        return f"{self._page}: {_answer(report)}"

    @property
    def _page(self) -> Path:
        return self.out or self.run_folder / PAGE


def _answer(report: RunReport) -> str:
    answer = [f"{report.answer.word} {report.answer.sentence}"] if report.answer else []
    return " ".join([*answer, *report.sentences]) or f"{report.facts.cells.done} cells done"
