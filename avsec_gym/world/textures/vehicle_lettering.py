"""Textures: what is written on vehicles: number plates, firms' names, destinations."""

from __future__ import annotations

import cv2
import numpy as np

from avsec_gym.world.textures.noise import fractal_noise, picture
from avsec_gym.world.textures.texture import Picture

_TOWNS = ("KA", "KA", "KA", "KA", "S", "HD", "RA", "GER", "PF", "F", "MA", "SUW")
_LETTERS = "ABCDEFGHJKLMNPRSTUVWXYZ"


_COMPANIES = (
    "KOCH",
    "BADEN LOGISTIK",
    "Frische Kiste",
    "MAYER",
    "SPEDITION HUBER",
    "Moebel Ruf",
    "EUROTRANS",
    "",
)
_COMPANY_COLOURS = (
    (240, 240, 238),
    (30, 70, 150),
    (235, 236, 230),
    (200, 60, 30),
    (35, 110, 60),
    (235, 190, 40),
    (60, 60, 70),
    (150, 60, 45),
)


def plate(variant: int, rng: np.random.Generator) -> Picture:
    """German: a blue strip with an E of stars and D, black letters on white, two small seals."""
    canvas = np.full((112, 512, 3), (236, 236, 230), np.uint8)
    letters = "".join(rng.choice(list(_LETTERS), int(rng.integers(1, 3))))
    town = _TOWNS[variant % len(_TOWNS)]
    number = str(int(rng.integers(10, 9999 if len(town + letters) < 5 else 999)))
    left, right = f"{town}", f"{letters} {number}"
    cv2.rectangle(canvas, (2, 2), (509, 109), (20, 20, 20), 4, cv2.LINE_AA)
    cv2.rectangle(canvas, (6, 6), (42, 105), (10, 50, 160), -1)
    cv2.circle(canvas, (24, 34), 11, (230, 200, 20), 2, cv2.LINE_AA)
    cv2.putText(
        canvas, "D", (14, 94), cv2.FONT_HERSHEY_DUPLEX, 0.9, (255, 255, 255), 2, cv2.LINE_AA
    )
    widths = [
        cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 2.75, 9)[0][0] for text in (left, right)
    ]
    squeeze = min(1.0, 418 / (sum(widths) + 44))
    wide = np.full((112, sum(widths) + 60, 3), (236, 236, 230), np.uint8)
    cv2.putText(wide, left, (6, 86), cv2.FONT_HERSHEY_SIMPLEX, 2.75, (12, 12, 12), 9, cv2.LINE_AA)
    seal = widths[0] + 26
    for y, colour in ((36, (60, 120, 70)), (74, (170, 150, 60))):
        cv2.circle(wide, (seal, y), 14, colour, -1, cv2.LINE_AA)
    cv2.putText(
        wide, right, (seal + 24, 86), cv2.FONT_HERSHEY_SIMPLEX, 2.75, (12, 12, 12), 9, cv2.LINE_AA
    )
    size = (int(wide.shape[1] * squeeze), 84)
    small = cv2.resize(wide[14:98], size, interpolation=cv2.INTER_AREA)
    start = 48 + (456 - size[0]) // 2
    canvas[14:98, start : start + size[0]] = small
    return picture(cv2.resize(canvas, (256, 56), interpolation=cv2.INTER_AREA))


def cargo_side(variant: int, rng: np.random.Generator) -> Picture:
    """The side of a box or tarpaulin, 8 by 2.5 m: lettering, a stripe, folds or ribs, road dirt."""
    height, width = 160, 512
    ground = np.array(_COMPANY_COLOURS[variant], np.uint8)
    canvas = np.full((height, width, 3), ground, np.uint8)
    dark = ground.astype(int).sum() < 380
    ink = (240, 240, 235) if dark else _COMPANY_COLOURS[(variant + 1) % 6 if variant else 1]
    if variant in (0, 2, 4, 6):
        cv2.rectangle(canvas, (0, 118), (width, 134), ink, -1)
    if variant in (1, 2, 5):
        corners = np.array([(400, 0), (470, 0), (420, height), (350, height)])
        cv2.fillPoly(canvas, [corners], _COMPANY_COLOURS[(variant + 2) % 6], cv2.LINE_AA)
    text = _COMPANIES[variant]
    if text:
        wide = cv2.getTextSize(text, cv2.FONT_HERSHEY_DUPLEX, 1.0, 3)[0][0]
        scale = min(2.2, 310.0 / wide)
        cv2.putText(
            canvas,
            text,
            (36, 96),
            cv2.FONT_HERSHEY_DUPLEX,
            scale,
            ink,
            max(2, int(3 * scale)),
            cv2.LINE_AA,
        )
    x = np.arange(width, dtype=np.float32)[None, :]
    folds = (2 * np.pi * 40 / width, 2 * np.pi * 12 / width)[variant % 2] * x
    shade = 1.0 + (0.22 if variant == 7 else 0.04) * np.cos(folds)
    shade = shade * (1.0 + 0.03 * fractal_noise(rng, height, width, cells=5))
    v = np.linspace(0.0, 1.0, height, dtype=np.float32)[:, None]
    shade = shade * (1.0 - 0.25 * np.clip((v - 0.8) / 0.2, 0.0, 1.0))
    result = canvas.astype(np.float32) * shade[..., None]
    result[:4] *= 0.7
    result[-6:] *= 0.5
    result[:, :4] *= 0.7
    result[:, -4:] *= 0.7
    return picture(result)


def van_sign(variant: int, _: np.random.Generator) -> Picture:
    """A firm's name and what it does, on white."""
    firm, trade = (
        ("WEBER", "Sanitaer + Heizung"),
        ("Elektro Kunz", "Tel. 0721 / 40 17 3"),
        ("BLITZ", "Paketdienst"),
        ("Malerbetrieb Vogt", "Meisterbetrieb"),
        ("BAECKEREI RAU", "seit 1926"),
        ("KRAUSE", "Glas & Fenster"),
    )[variant]
    ink = (
        (200, 30, 25),
        (25, 60, 150),
        (190, 20, 60),
        (30, 110, 60),
        (120, 60, 20),
        (20, 90, 140),
    )[variant]
    canvas = np.full((128, 384, 3), 245, np.uint8)
    scale = 330.0 / cv2.getTextSize(firm, cv2.FONT_HERSHEY_DUPLEX, 1.0, 3)[0][0]
    scale = min(scale, 2.4)
    cv2.putText(
        canvas,
        firm,
        (24, 66),
        cv2.FONT_HERSHEY_DUPLEX,
        scale,
        ink,
        max(2, int(2.5 * scale)),
        cv2.LINE_AA,
    )
    cv2.putText(
        canvas, trade, (26, 108), cv2.FONT_HERSHEY_SIMPLEX, 0.95, (60, 60, 60), 2, cv2.LINE_AA
    )
    return canvas


def destination(_: int, __: np.random.Generator) -> Picture:
    """Amber letters on black."""
    canvas = np.full((48, 256, 3), 12, np.uint8)
    cv2.putText(
        canvas,
        "2 Wolfartsweier",
        (10, 34),
        cv2.FONT_HERSHEY_DUPLEX,
        0.85,
        (250, 180, 40),
        2,
        cv2.LINE_AA,
    )
    return picture(canvas)
