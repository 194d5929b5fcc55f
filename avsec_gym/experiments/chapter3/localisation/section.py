"""What a run shows of damage located and repaired."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from avsec_gym.drawing.page_figure import CaptionedImage, Figure, PictureRow
from avsec_gym.errors import AvsecError
from avsec_gym.experiments.chapter3.localisation.in_words import localisation_sentences
from avsec_gym.experiments.chapter3.localisation.rates import (
    LocalisationSummary,
    localisation_summary,
)
from avsec_gym.experiments.chapter3.localisation.tables import table_of_localisation
from avsec_gym.experiments.chapter3.recordings import assets_in_words
from avsec_gym.experiments.json_rows import row_json
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section

if TYPE_CHECKING:
    from avsec_gym.experiments.chapter3.localisation.repair_pictures import RepairPicture


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``localisation``.

    Raises:
        DataError: The recordings are not where they were.
    """
    summary = localisation_summary(run, run.configuration)
    if not summary:
        return Findings(data={"localisation": None})
    problems = []
    pictures: Sequence[RepairPicture] = ()
    if request.pictures:
        try:
            pictures = _repaired_again(run, summary, request)
        except AvsecError as error:
            problems.append(f"no pictures of repairs: {error}")
    section = localisation_section(summary, pictures)
    return Findings(
        [section],
        {"localisation": row_json(summary)},
        remarks=assets_in_words(run.configuration),
        problems=problems,
    )


def localisation_section(
    summary: LocalisationSummary, pictures: Sequence[RepairPicture] = ()
) -> Section:
    """The section of a summary.

    Args:
        summary: The rows of a run.
        pictures: Frames attacked and repaired.
    """
    return Section(
        "localisation",
        "Where is the damage, and what does its repair leave?",
        localisation_sentences(summary),
        [table_of_localisation(summary), *([_figure(pictures)] if pictures else [])],
        link="Damage and its repair",
    )


def _figure(pictures: Sequence[RepairPicture]) -> Figure:
    shown = [
        CaptionedImage(
            picture.image,
            picture.title,
            f"{picture.title}: clean, attacked, found beside true, repaired",
            warning=""
            if picture.as_stored
            else "Repeated here it came out otherwise than in the run.",
        )
        for picture in pictures
    ]
    return Figure(
        "One attack of each kind, where it is located as well as usual, and worst",
        pictures=[PictureRow(shown, "repairs")],
        note="Chosen by rule, not by eye: the frames with the median and with the lowest IoU. Of a"
        " bogus return the points are shown in camera 2’s image, the nearer the redder.",
        label="Frames attacked and repaired",
    )


def _repaired_again(
    run: RunFolder, summary: LocalisationSummary, request: ReportRequest
) -> list[RepairPicture]:
    from avsec_gym.drawing.scenario_picture import save_picture
    from avsec_gym.experiments.chapter3.localisation.repair_pictures import repair_pictures
    from avsec_gym.experiments.chapter3.localisation.repaired_frames import RepairedFrames

    run.use_its_threads()
    with request.progress("repairing again") as shown:
        frames = RepairedFrames(run.configuration)
        found = repair_pictures(summary, frames, request.pictures, shown)
    if request.keeps_pictures:
        for picture in found:
            save_picture(picture.figure, run.figures / f"{picture.file}.png", overwrite=True)
    return found
