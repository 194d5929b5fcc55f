"""A window for `render_mode="human"`; pictures themselves are made headless."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError


class Window:
    """Shows pictures one after the other.

    Args:
        title: The window's.
        fps: Pictures a second.

    Raises:
        ConfigurationError: pygame is not installed.
    """

    def __init__(self, title: str, fps: float) -> None:
        try:
            import pygame
        except ImportError as error:
            raise ConfigurationError(
                "render_mode='human' needs pygame: pip install 'avsec-gym[view]',"
                " or use render_mode='rgb_array'"
            ) from error
        self._pygame: Any = pygame
        self._title, self._fps = title, fps
        self._screen: Any = None
        self._clock = pygame.time.Clock()

    def show(self, picture: NDArray[np.uint8]) -> None:
        """Show an RGB picture, shape (H, W, 3), and wait until the next is due."""
        pygame = self._pygame
        if self._screen is None:
            pygame.display.init()
            pygame.display.set_caption(self._title)
            self._screen = pygame.display.set_mode((picture.shape[1], picture.shape[0]))
        pygame.event.pump()
        pygame.surfarray.blit_array(self._screen, picture.swapaxes(0, 1))
        pygame.display.flip()
        self._clock.tick(self._fps)

    def close(self) -> None:
        """Close it."""
        self._pygame.display.quit()
        self._screen = None
