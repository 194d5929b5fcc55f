"""How environments draw themselves: pictures are made headless, a window only shows them."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, Generic, TypeVar

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import one_of
from avsec_gym.errors import ConfigurationError

Observation = TypeVar("Observation")


class DrawnEnv(gym.Env[Observation, NDArray[np.float32]], Generic[Observation]):
    """An environment with pictures; one that inherits it calls `shown` after reset and step.

    Args:
        render_mode: None, ``rgb_array`` or ``human``.

    Raises:
        ConfigurationError: Another mode.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - as Gymnasium declares it
        "render_modes": ["rgb_array", "human"],
        "render_fps": 1,
    }
    title = "avsec-gym"
    """Title of the window."""

    def __init__(self, render_mode: str | None = None) -> None:
        if render_mode is not None:
            render_mode = one_of("render_mode", render_mode, self.metadata["render_modes"])
        self.render_mode = render_mode
        self._window: Window | None = None

    @abstractmethod
    def picture(self) -> NDArray[np.uint8] | None:
        """How it looks now, red, green, blue, shape (H, W, 3); None before the first reset."""

    def render(self) -> NDArray[np.uint8] | None:
        """The picture, or None where a window shows it."""
        picture = None if self.render_mode is None else self.picture()
        if picture is None or self.render_mode == "rgb_array":
            return picture
        if self._window is None:
            self._window = Window(self.title, self.metadata["render_fps"])
        self._window.show(picture)
        return None

    def shown(self) -> None:
        """Bring the window up to date, where there is to be one."""
        if self.render_mode == "human":
            self.render()

    def close(self) -> None:
        """Close the window, if one is open."""
        if self._window is not None:
            self._window.close()
            self._window = None


class Window:
    """Shows pictures one after the other.

    Args:
        title: The title of the window.
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
