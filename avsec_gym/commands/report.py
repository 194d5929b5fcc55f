"""`avsec report`: what a run came to, as one page with pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from avsec_gym import console
from avsec_gym.errors import AvsecError, ConfigurationError, DataError

if TYPE_CHECKING:
    from avsec_gym.experiments.chapter3.localisation.repair_pictures import RepairPicture
    from avsec_gym.experiments.chapter5.outcomes import Outcomes
    from avsec_gym.experiments.chapter5.section.scene_strip import Strip
    from avsec_gym.experiments.chapter5.section.spread_pictures import SpreadPicture
    from avsec_gym.runs.run_folder import RunFolder

PAGE = "report.html"
SPREAD = "feature_spread.png"


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
    """Of `identification`: how many of the judged moments, the first ones, were looked at while a
    method was made; its rates are also told without them."""
    overwrite: bool = False
    """Write over files that --out and --markdown name."""
    json: bool = False
    """Print all figures as JSON."""

    def run(self) -> int:
        """Do it; the exit code: 3 where pictures could not be made."""
        report, code = self.written()
        if self.json:
            console.print_json("report", report)
        console.say(self.sentence(report))
        return code

    def written(self) -> tuple[dict[str, Any], int]:
        """Write the page; all its figures, and the exit code."""
        from avsec_gym.report.html import html_page
        from avsec_gym.report.run_markdown import markdown_page
        from avsec_gym.report.run_remarks import remarks
        from avsec_gym.report.run_report import holds_chapter_5, outcomes_of, run_report
        from avsec_gym.runs.run_folder import RunFolder
        from avsec_gym.storage.text_files import write_text

        if self.pictures < 0:
            raise ConfigurationError(f"--pictures is 0 or more, got {self.pictures}")
        if self.looked_at < 0:
            raise ConfigurationError(f"--looked-at is 0 or more, got {self.looked_at}")
        folder = RunFolder.open(self.run_folder)
        for path in (self.out, self.markdown):
            if path is not None and path.exists() and not self.overwrite:
                raise DataError(
                    "the file exists.", path=path, remedy="Name another, or use --overwrite."
                )
        outcomes = outcomes_of(folder) if holds_chapter_5(folder) else None
        with console.progress("reading") as shown:
            report = run_report(folder, outcomes, shown, self.looked_at)
        for remark in remarks(report):
            console.say(f"avsec: {remark}")
        strips, failed = self._strips(folder, outcomes) if outcomes else ([], False)
        spreads, blank = self._spreads(folder, report["spread"])
        repairs, unseen = self._repairs(folder, report["localisation"])
        page = html_page(report, strips, spreads, repairs)
        write_text(self._page, page, overwrite=True)
        if self.markdown is not None:
            write_text(self.markdown, markdown_page(report), overwrite=True)
        return report, console.DONE_IN_PART if failed or blank or unseen else console.DONE

    def sentence(self, report: dict[str, Any]) -> str:
        """Where the page is, and its answer."""
        return f"{self._page}: {_answer(report)}"

    @property
    def _page(self) -> Path:
        return self.out or self.run_folder / PAGE

    def _strips(self, folder: RunFolder, outcomes: Outcomes) -> tuple[list[Strip], bool]:
        """The pictures, and whether some are missing."""
        from avsec_gym.experiments.chapter5.scenes import OPTIONS
        from avsec_gym.experiments.chapter5.section.telling_scenes import telling_scenes

        options = {**OPTIONS, **folder.configuration.options}
        telling = telling_scenes(outcomes, self.pictures, options["score_threshold"])
        if not telling:
            return [], False
        from avsec_gym.experiments.chapter5 import attacked_drives
        from avsec_gym.experiments.chapter5.section.scene_strip import scene_strips

        _use_threads(int(folder.manifest["threads"]))
        try:
            drives = attacked_drives.AttackedDrives(folder.configuration)
            with console.progress("repeating attacks") as shown:
                return scene_strips(telling, outcomes, drives, shown), False
        except AvsecError as error:
            console.say(f"avsec: no pictures: {error}")
            return [], True

    def _spreads(
        self, folder: RunFolder, rows: list[dict[str, Any]]
    ) -> tuple[list[SpreadPicture], bool]:
        """The feature maps, and whether they are missing."""
        if not rows or not self.pictures:
            return [], False
        from avsec_gym.experiments.chapter5.feature_spread_figure import draw_feature_spread
        from avsec_gym.experiments.chapter5.patch_spreads import PatchSpreads
        from avsec_gym.experiments.chapter5.section.spread_pictures import (
            shown_spreads,
            spread_picture,
        )

        _use_threads(int(folder.manifest["threads"]))
        try:
            with console.progress("following patches") as shown:
                spreads = shown_spreads(rows, PatchSpreads(folder.configuration), shown)
        except AvsecError as error:
            console.say(f"avsec: no feature maps: {error}")
            return [], True
        if self.out is None:  # Else nothing is written into the run's folder.
            draw_feature_spread(spreads, folder.figures / SPREAD)
        return [spread_picture(title, each) for title, each in spreads.items()], False

    def _repairs(
        self, folder: RunFolder, summary: dict[str, Any] | None
    ) -> tuple[list[RepairPicture], bool]:
        """Pictures of repaired moments, and whether they are missing."""
        if not summary or not self.pictures:
            return [], False
        from avsec_gym.drawing.scenario_picture import save_picture
        from avsec_gym.experiments.chapter3.localisation.repair_pictures import repair_pictures
        from avsec_gym.experiments.chapter3.localisation.repaired_moments import RepairedMoments

        _use_threads(int(folder.manifest["threads"]))
        try:
            with console.progress("repairing again") as shown:
                moments = RepairedMoments(folder.configuration)
                found = repair_pictures(summary, moments, self.pictures, shown)
        except AvsecError as error:
            console.say(f"avsec: no pictures of repairs: {error}")
            return [], True
        if self.out is None:  # Else nothing is written into the run's folder.
            for one in found:
                save_picture(one.figure, folder.figures / f"{one.file}.png", overwrite=True)
        return found, False


def _use_threads(count: int) -> None:
    """As many as the run had: the last digits of gradients depend on it."""
    import torch

    torch.set_num_threads(count)


def _answer(report: dict[str, Any]) -> str:
    from avsec_gym.experiments.chapter3.identification.in_words import (
        five_sentences,
        validation_sentences,
    )
    from avsec_gym.experiments.chapter3.localisation.in_words import localisation_sentences
    from avsec_gym.experiments.chapter3.objects.in_words import optical_sentences

    said = validation_sentences(report["validation"]) if report["validation"] else []
    said += five_sentences(report)
    if said := [*said, *optical_sentences(report), *localisation_sentences(report)]:
        return " ".join(said)
    if "answer" not in report:
        return f"{report['cells']['done']} cells done"
    return f"{report['answer']['word']} {report['answer']['sentence']}"
