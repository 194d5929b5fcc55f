"""The page in a real browser: both colour schemes, a phone's width, sorting, no errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.slow


@pytest.fixture
def opened(browser: Any, page: Path) -> Iterator[Callable[..., Any]]:
    """Opens the page; in the end there may be neither errors nor requests to anywhere else."""
    contexts, complaints = [], []

    def open_(width: int = 1280, scheme: str = "light", **options: Any) -> Any:
        viewport = {"width": width, "height": 800}
        context = browser.new_context(viewport=viewport, color_scheme=scheme, **options)
        contexts.append(context)
        tab = context.new_page()
        tab.on("console", lambda message: complaints.append(message.text))
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.on(
            "request",
            lambda request: (
                request.url.startswith(("file:", "data:")) or complaints.append(request.url)
            ),
        )
        tab.goto(page.as_uri())
        return tab

    yield open_
    for context in contexts:
        context.close()
    assert complaints == []


def brightness(tab: Any, of: str = "body") -> float:
    colour = tab.eval_on_selector(of, "one => getComputedStyle(one).backgroundColor")
    levels = [float(level) for level in colour.strip("rgba()").split(",")[:3]]
    return sum(levels) / 3


def test_it_follows_the_system_and_the_switch(opened: Callable[..., Any]) -> None:
    assert brightness(opened()) > 230
    tab = opened(scheme="dark")
    assert brightness(tab) < 40
    assert brightness(tab, ".card") < 60
    # Marks and words of drawings follow, too.
    ink = tab.eval_on_selector("svg .name", "one => getComputedStyle(one).fill")
    assert ink == tab.eval_on_selector("h1", "one => getComputedStyle(one).color")
    switch = tab.get_by_role("button", name="Colours: auto")
    switch.click()
    assert tab.get_by_role("button", name="Colours: light").is_visible()
    assert brightness(tab) > 230
    tab.reload()
    assert brightness(tab) > 230


@pytest.mark.parametrize("width", [375, 768, 1280])
def test_nothing_is_wider_than_the_page(opened: Callable[..., Any], width: int) -> None:
    tab = opened(width)
    for details in tab.query_selector_all("summary"):
        details.click()
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    boxes = tab.eval_on_selector_all(
        ".box", "all => all.map(one => [one.scrollWidth > one.clientWidth, one.tabIndex])"
    )
    # What is wider scrolls inside its own box, by keyboard too.
    assert all(index == 0 for _, index in boxes)
    assert width > 375 or any(wider for wider, _ in boxes)


def test_the_first_screen_answers(opened: Callable[..., Any]) -> None:
    tab = opened()
    assert "Does a detector" in tab.inner_text("h1")
    for selector in (".word", ".first svg"):
        place = tab.query_selector(selector).bounding_box()
        assert place["y"] + place["height"] < 800, selector
    assert len(tab.query_selector_all("table")) > 10
    assert len(tab.query_selector_all("figure.strip")) == 3
    loaded = "all => all.every(one => one.complete && one.naturalWidth === 1242)"
    assert tab.eval_on_selector_all(".strip img", loaded)


def test_tables_sort_and_filter(opened: Callable[..., Any]) -> None:
    tab = opened()
    sheet = tab.locator(".sortable", has_text="What each attack takes")

    def column(number: int) -> list[str]:
        cells = sheet.locator(f"tbody tr:not([hidden]) td:nth-child({number})")
        return [cell.replace("−", "-").partition("[")[0] for cell in cells.all_inner_texts()]

    unsorted = column(3)
    head = sheet.locator("th", has_text="AP taken")
    head.get_by_role("button").focus()
    tab.keyboard.press("Enter")
    values = [float(text) for text in column(3)]
    assert head.get_attribute("aria-sort") == "ascending"
    assert values == sorted(values)
    assert values != [float(text) for text in unsorted]
    head.get_by_role("button").click()
    assert [float(text) for text in column(3)] == values[::-1]
    sheet.get_by_label("detector").select_option("DSGN")
    assert set(column(1)) == {"DSGN"}
    sheet.get_by_role("searchbox").fill("patch specific")
    assert column(2) == ["specific patch"]
    assert sheet.locator(".count").inner_text() == f"1 of {len(unsorted)} rows"


def test_marks_tell_what_they_are(opened: Callable[..., Any]) -> None:
    tab = opened()
    mark = tab.locator(".first .mark:not(.hollow)").last
    mark.focus()
    hint = tab.locator("#hint")
    assert hint.is_visible()
    assert "average precision" in hint.inner_text()
    tab.keyboard.press("Escape")
    assert not hint.is_visible()
    told = tab.locator("td[data-hint]").first
    told.hover()
    assert hint.is_visible()
    tab.keyboard.press("Escape")
    told.focus()
    assert hint.is_visible()
    assert hint.inner_text() == told.get_attribute("data-hint")


def test_what_is_printed_fits_the_paper(opened: Callable[..., Any]) -> None:
    """Nothing is wider than A4 between margins of a centimetre, which are 718 pixels."""
    tab = opened()
    tab.emulate_media(media="print")
    tab.set_viewport_size({"width": 718, "height": 1000})
    assert not tab.locator("header.top button").first.is_visible()
    wide = tab.evaluate(
        "() => [...document.querySelectorAll('.panels > *, .layers > *, img, svg, canvas')]"
        ".filter(one => one.getBoundingClientRect().right > 720).map(one => one.outerHTML)"
    )
    assert wide == []


def test_boxes_in_images_can_be_hidden(opened: Callable[..., Any]) -> None:
    tab = opened()
    path = tab.locator(".seen path").first
    assert path.is_visible()
    tab.get_by_label("boxes in images").uncheck()
    assert not path.is_visible()


def test_it_is_complete_without_scripts(opened: Callable[..., Any]) -> None:
    tab = opened(scheme="dark", java_script_enabled=False)
    assert brightness(tab) < 40
    assert tab.locator(".word").is_visible()
    assert tab.locator("table").count() > 10
    assert not tab.locator("button.theme").is_visible()


PIXELS = "one => one.toDataURL()"


def test_a_scene_turns_by_hand_and_by_keys_and_drives(opened: Callable[..., Any]) -> None:
    tab = opened(reduced_motion="reduce")
    root = tab.locator("details.turn").first
    canvas = root.locator("canvas")
    root.locator("summary").click()
    looks = [canvas.evaluate(PIXELS)]
    # Closed, then empty: something is drawn.
    blank = "one => {const two = document.createElement('canvas'); two.width = one.width;"
    blank += " two.height = one.height; return two.toDataURL()}"
    assert looks[0] != canvas.evaluate(blank)

    def changed() -> bool:
        looks.append(canvas.evaluate(PIXELS))
        return looks[-1] != looks[-2]

    box = canvas.bounding_box()
    tab.mouse.move(box["x"] + 200, box["y"] + 200)
    tab.mouse.down()
    tab.mouse.move(box["x"] + 300, box["y"] + 180, steps=3)
    tab.mouse.up()
    assert changed()
    for key in ("ArrowLeft", "ArrowUp", "+", "-"):
        tab.keyboard.press(key)
        assert changed(), key
    tab.keyboard.press("Control+ArrowLeft")  # The browser's.
    assert not changed()
    for button in ("From above", "From behind", "Nearer", "Farther"):
        root.get_by_role("button", name=button).click()
        assert changed(), button
    root.get_by_label("believed").click()
    assert changed()
    # The drive, step by step and by itself, to its end.
    time = root.locator("output")
    assert time.inner_text() == "0.0 s"
    root.locator(".time input").focus()
    tab.keyboard.press("ArrowRight")
    assert time.inner_text() == "0.1 s"
    assert changed()
    last = int(root.locator(".time input").get_attribute("max"))
    root.get_by_role("button", name="Drive").click()
    root.get_by_role("button", name="Drive").wait_for(timeout=10_000)
    assert time.inner_text().startswith(f"{0.1 * last:.1f} s")
    # Another drive begins where this one did.
    root.locator("select").select_option("0")
    assert time.inner_text() == "0.0 s"


def test_the_thesis_values_go_by_a_switch_that_is_remembered(opened: Callable[..., Any]) -> None:
    tab = opened()
    shown = "all => all.filter(one => one.getClientRects().length).length"
    switch = tab.get_by_role("button", name="The thesis’ values")
    marks, cells, keys = ".mark.theirs", "td .thesis", ".legend .theirs"
    assert all(tab.eval_on_selector_all(each, shown) for each in (marks, cells, keys))
    switch.click()
    assert switch.get_attribute("aria-pressed") == "false"
    assert not any(tab.eval_on_selector_all(each, shown) for each in (marks, cells, keys))
    ours = tab.eval_on_selector_all(".mark:not(.theirs)", shown)
    assert ours > 20
    tab.reload()
    assert not tab.eval_on_selector_all(marks, shown)
    tab.get_by_role("button", name="The thesis’ values").click()
    assert tab.eval_on_selector_all(marks, shown)
    assert tab.eval_on_selector_all(".mark:not(.theirs)", shown) == ours
