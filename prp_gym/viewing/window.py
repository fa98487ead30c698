"""`Window`: a session in MuJoCo's viewer, with the keyboard as its only control."""

from collections.abc import Callable

from prp_gym.physics.rendering import WindowRenderer
from prp_gym.viewing.real_time import RealTime
from prp_gym.viewing.session import Session
from prp_gym.viewing.viewer import Viewer

_SPACE, _RIGHT, _UP, _DOWN, _BACKSPACE = 32, 262, 265, 264, 259  # codes of GLFW
_FASTEST, _SLOWEST = 8.0, 1.0 / 32.0

KEYS = (
    "space: pause and go on; right arrow: single step; up and down arrow: twice and half the speed;"
    " backspace: start the episode again"
)
"""What the keys of the window do."""


class Window:
    """A window that shows a session.

    Args:
        viewer: loop that runs the session.
        say: function that tells the user something.

    Raises:
        RenderingError: there is no display.
    """

    def __init__(self, viewer: Viewer, say: Callable[[str], None]) -> None:
        self._viewer, self._say = viewer, say
        physics = viewer.session.inner.physics
        self._renderer = WindowRenderer(physics.model(), physics.data(), "task", self._take_key)
        self._behind = False

    def show(self, viewer: Viewer) -> bool:
        """Show the present state; False once the user has closed the window."""
        inner = viewer.session.inner
        self._renderer.show(inner.physics.model(), inner.physics.data(), inner.overlay(0))
        self._tell_if_behind(viewer.real_time)
        return self._renderer.is_open

    def say(self, text: str) -> None:
        """Tell the user why something was refused or failed."""
        self._say(text)

    def close(self) -> None:
        """Close the window."""
        self._renderer.close()

    def _tell_if_behind(self, real_time: RealTime) -> None:
        """Say once that the simulation cannot keep the chosen speed."""
        if real_time.falls_behind and not self._behind:
            self._say(
                f"real-time factor {real_time.factor:.2f} (chosen {real_time.speed:g}): slower than chosen"
            )
        self._behind = real_time.falls_behind

    def _take_key(self, code: int) -> None:
        """Wish what a key stands for; called by the thread of the window."""
        act = key_action(code, self._viewer)
        if act is not None:
            self._viewer.wish(act)


def key_action(code: int, viewer: Viewer) -> Callable[[], None] | None:
    """What a key stands for; None for any other key.

    Args:
        code: code of the key, as GLFW has it.
        viewer: loop that runs the session.
    """
    session = viewer.session
    actions: dict[int, Callable[[], None]] = {
        _SPACE: lambda: session.pause() if session.running else session.resume(),
        _RIGHT: lambda: _single_step(session),
        _UP: lambda: _change_speed(viewer.real_time, 2.0),
        _DOWN: lambda: _change_speed(viewer.real_time, 0.5),
        _BACKSPACE: lambda: session.reset(session.seed),
    }
    return actions.get(code)


def _single_step(session: Session) -> None:
    session.pause()
    session.step()


def _change_speed(real_time: RealTime, factor: float) -> None:
    real_time.speed = min(_FASTEST, max(_SLOWEST, real_time.speed * factor))
    real_time.start()
