"""An alphabet of strokes of even width, in the manner of German road signs (DIN 1451)."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

Stroke = NDArray[np.float64]
"""Points of a line, shape (n, 2), to the right and up; capitals are 1 high on the line y = 0."""

_SPACING = 0.3
_SPACE = 0.35


def written(text: str) -> tuple[list[Stroke], float]:
    """The strokes of a line of text, and its width in heights of a capital.

    Raises:
        KeyError: A sign that the alphabet does not have; it has letters with German umlauts,
            digits and ``. , - ! / :``.
    """
    strokes: list[Stroke] = []
    right = 0.0
    for sign in text:
        if sign == " ":
            right += _SPACE
            continue
        glyph = _alphabet()[sign]
        strokes += [np.add(stroke, (right, 0.0)) for stroke in glyph]
        right += max(float(stroke[:, 0].max()) for stroke in glyph) + _SPACING
    return strokes, max(right - _SPACING, 0.0)


def _arc(x: float, y: float, width: float, height: float, start: float, end: float) -> Stroke:
    """Part of an ellipse with these radii, from one angle to another, degrees."""
    angle = np.radians(np.linspace(start, end, 2 + int(abs(end - start) / 20)))
    return np.stack([x + width * np.cos(angle), y + height * np.sin(angle)], axis=1)


def _line(*points: float) -> Stroke:
    return np.array(points, float).reshape(-1, 2)


def _joined(*parts: Stroke) -> Stroke:
    return np.concatenate(parts)


@functools.cache
def _alphabet() -> dict[str, list[Stroke]]:
    signs = _capitals() | _small_letters() | _digits()
    dots = {"Ä": ("A", 1.22, 0.28), "Ö": ("O", 1.22, 0.25), "Ü": ("U", 1.22, 0.25)}
    dots |= {"ä": ("a", 0.92, 0.2), "ö": ("o", 0.92, 0.21), "ü": ("u", 0.92, 0.2)}
    for sign, (base, y, x) in dots.items():
        pair = [_line(x - 0.12, y, x - 0.12, y), _line(x + 0.12, y, x + 0.12, y)]
        signs[sign] = [*signs[base], *pair]
    return signs


def _capitals() -> dict[str, list[Stroke]]:
    # Parts that several letters share; x to the right, y up, the height is 1.
    stem = _line(0, 0, 0, 1)
    ring = _joined(_arc(0.25, 0.75, 0.25, 0.25, 0, 180), _arc(0.25, 0.25, 0.25, 0.25, 180, 360))
    oval = _joined(ring, ring[:1])
    bowl = _joined(_line(0, 0, 0, 1), _arc(0.24, 0.73, 0.24, 0.27, 90, -90), _line(0, 0.46))
    lower = _arc(0.25, 0.25, 0.25, 0.25, 180, 350)
    return {
        "A": [_line(0, 0, 0.28, 1, 0.56, 0), _line(0.09, 0.3, 0.47, 0.3)],
        "B": [
            _joined(_line(0, 0, 0, 1), _arc(0.25, 0.76, 0.2, 0.24, 90, -90), _line(0, 0.52)),
            _joined(_arc(0.25, 0.26, 0.24, 0.26, 90, -90), _line(0, 0)),
        ],
        "C": [_joined(_arc(0.25, 0.75, 0.25, 0.25, 10, 180), lower)],
        "D": [
            _joined(
                stem, _arc(0.2, 0.7, 0.3, 0.3, 90, 0), _arc(0.2, 0.3, 0.3, 0.3, 0, -90), stem[:1]
            )
        ],
        "E": [_line(0.45, 1, 0, 1, 0, 0, 0.45, 0), _line(0, 0.52, 0.38, 0.52)],
        "F": [_line(0.45, 1, 0, 1, 0, 0), _line(0, 0.5, 0.37, 0.5)],
        "G": [_joined(_arc(0.25, 0.75, 0.25, 0.25, 10, 180), lower, _line(0.5, 0.46, 0.28, 0.46))],
        "H": [stem, _line(0.5, 0, 0.5, 1), _line(0, 0.52, 0.5, 0.52)],
        "I": [stem],
        "J": [_joined(_line(0.38, 1), _arc(0.19, 0.22, 0.19, 0.22, 0, -165))],
        "K": [stem, _line(0.48, 1, 0, 0.4), _line(0.16, 0.6, 0.5, 0)],
        "L": [_line(0, 1, 0, 0, 0.43, 0)],
        "M": [_line(0, 0, 0, 1, 0.3, 0.4, 0.6, 1, 0.6, 0)],
        "N": [_line(0, 0, 0, 1, 0.5, 0, 0.5, 1)],
        "O": [oval],
        "P": [bowl],
        "Q": [oval, _line(0.3, 0.24, 0.52, -0.02)],
        "R": [bowl, _line(0.22, 0.46, 0.5, 0)],
        "S": [
            _joined(
                _arc(0.25, 0.755, 0.24, 0.245, 15, 270), _arc(0.25, 0.255, 0.25, 0.255, 90, -165)
            )
        ],
        "T": [_line(0, 1, 0.52, 1), _line(0.26, 1, 0.26, 0)],
        "U": [_joined(_line(0, 1), _arc(0.25, 0.25, 0.25, 0.25, 180, 360), _line(0.5, 1))],
        "V": [_line(0, 1, 0.28, 0, 0.56, 1)],
        "W": [_line(0, 1, 0.2, 0, 0.4, 0.9, 0.6, 0, 0.8, 1)],
        "X": [_line(0, 0, 0.52, 1), _line(0, 1, 0.52, 0)],
        "Y": [_line(0, 1, 0.27, 0.45, 0.54, 1), _line(0.27, 0.45, 0.27, 0)],
        "Z": [_line(0, 1, 0.48, 1, 0, 0, 0.5, 0)],
    }


def _small_letters() -> dict[str, list[Stroke]]:
    # Parts that several letters share; letters without ascender are 0.7 high.
    ring = _joined(_arc(0.21, 0.49, 0.21, 0.21, 0, 180), _arc(0.21, 0.21, 0.21, 0.21, 180, 360))
    oval = _joined(ring, ring[:1])
    foot = _line(0, 0, 0, 0.7)
    arch = _joined(_arc(0.2, 0.48, 0.2, 0.22, 180, 0), _line(0.4, 0))
    narrow = _joined(_arc(0.16, 0.5, 0.16, 0.2, 180, 0), _line(0.32, 0))
    return {
        "a": [
            _joined(_arc(0.2, 0.49, 0.2, 0.21, 150, 0), _line(0.4, 0)),
            _joined(_line(0.4, 0.4), _arc(0.19, 0.2, 0.19, 0.2, 90, 290), _line(0.4, 0.12)),
        ],
        "b": [_line(0, 0, 0, 1), oval],
        "c": [_joined(_arc(0.2, 0.49, 0.2, 0.21, 25, 180), _arc(0.2, 0.21, 0.2, 0.21, 180, 335))],
        "d": [_line(0.42, 0, 0.42, 1), oval],
        "e": [
            _joined(
                _line(0, 0.36),
                _arc(0.2, 0.48, 0.2, 0.22, -30, 180),
                _arc(0.2, 0.21, 0.2, 0.21, 180, 330),
            )
        ],
        "f": [
            _joined(_line(0.1, 0), _arc(0.27, 0.8, 0.17, 0.2, 180, 90)),
            _line(0, 0.68, 0.27, 0.68),
        ],
        "g": [oval, _joined(_line(0.42, 0.7), _arc(0.21, -0.08, 0.21, 0.2, 0, -160))],
        "h": [_line(0, 0, 0, 1), arch],
        "i": [foot, _line(0, 0.95, 0, 0.96)],
        "j": [
            _joined(_line(0.12, 0.7), _arc(0, -0.1, 0.12, 0.18, 0, -90)),
            _line(0.12, 0.95, 0.12, 0.96),
        ],
        "k": [_line(0, 0, 0, 1), _line(0.37, 0.7, 0, 0.3), _line(0.13, 0.44, 0.4, 0)],
        "l": [_joined(_line(0, 1), _arc(0.13, 0.13, 0.13, 0.13, 180, 270))],
        "m": [foot, narrow, np.add(narrow, (0.32, 0.0))],
        "n": [foot, arch],
        "o": [oval],
        "p": [_line(0, 0.7, 0, -0.28), oval],
        "q": [_line(0.42, 0.7, 0.42, -0.28), oval],
        "r": [foot, _arc(0.2, 0.48, 0.2, 0.22, 180, 60)],
        "s": [
            _joined(_arc(0.19, 0.53, 0.17, 0.17, 25, 270), _arc(0.19, 0.18, 0.19, 0.18, 90, -155))
        ],
        "t": [
            _joined(_line(0.12, 0.95), _arc(0.26, 0.14, 0.14, 0.14, 180, 280)),
            _line(0, 0.68, 0.28, 0.68),
        ],
        "u": [
            _joined(_line(0, 0.7), _arc(0.2, 0.22, 0.2, 0.22, 180, 360), _line(0.4, 0.7)),
            _line(0.4, 0.3, 0.4, 0),
        ],
        "v": [_line(0, 0.7, 0.21, 0, 0.42, 0.7)],
        "w": [_line(0, 0.7, 0.16, 0, 0.32, 0.6, 0.48, 0, 0.64, 0.7)],
        "x": [_line(0, 0, 0.4, 0.7), _line(0, 0.7, 0.4, 0)],
        "y": [_line(0, 0.7, 0.21, 0), _line(0.42, 0.7, 0.12, -0.28)],
        "z": [_line(0, 0.7, 0.37, 0.7, 0, 0, 0.38, 0)],
        "ß": [
            _joined(
                _line(0, 0),
                _arc(0.2, 0.79, 0.2, 0.21, 180, -50),
                _line(0.18, 0.56),
                _arc(0.2, 0.27, 0.22, 0.27, 60, -115),
            )
        ],
    }


def _digits() -> dict[str, list[Stroke]]:
    zero = _joined(_arc(0.25, 0.72, 0.25, 0.28, 0, 180), _arc(0.25, 0.28, 0.25, 0.28, 180, 360))
    six = _joined(_line(0.38, 1, 0.06, 0.45), _arc(0.25, 0.29, 0.25, 0.29, 140, 510))
    return {
        "0": [_joined(zero, zero[:1])],
        "1": [_line(0, 0.76, 0.22, 1, 0.22, 0)],
        "2": [_joined(_arc(0.24, 0.74, 0.24, 0.26, 170, -35), _line(0, 0, 0.5, 0))],
        "3": [
            _joined(_arc(0.22, 0.76, 0.22, 0.24, 155, -90), _arc(0.22, 0.26, 0.26, 0.26, 90, -155))
        ],
        "4": [_line(0.28, 1, 0, 0.23, 0.54, 0.23), _line(0.38, 0.5, 0.38, 0)],
        "5": [_joined(_line(0.45, 1, 0.06, 1, 0.03, 0.52), _arc(0.23, 0.3, 0.26, 0.3, 120, -150))],
        "6": [six],
        "7": [_line(0, 1, 0.48, 1, 0.14, 0)],
        "8": [_arc(0.25, 0.76, 0.21, 0.24, 0, 360), _arc(0.25, 0.26, 0.25, 0.26, 0, 360)],
        "9": [np.array([0.5, 1.0]) - six],
        ".": [_line(0, 0.0, 0, 0.01)],
        ",": [_line(0.06, 0.02, 0, -0.15)],
        "-": [_line(0, 0.42, 0.28, 0.42)],
        "!": [_line(0, 1, 0, 0.3), _line(0, 0, 0, 0.01)],
        "/": [_line(0, -0.1, 0.4, 1.05)],
        ":": [_line(0, 0.1, 0, 0.11), _line(0, 0.58, 0, 0.59)],
    }
