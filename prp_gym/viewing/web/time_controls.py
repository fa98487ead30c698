"""`TimeControls`: run, pause, single step, speed, reset with a seed, camera."""

from typing import Any

from prp_gym.viewing.viewer import Viewer
from prp_gym.viewing.web.cameras import CAMERAS, look

_SPEEDS = ("0.05", "0.1", "0.25", "0.5", "1", "2", "4")
_RUN, _PAUSE = "Go on", "Pause"


class TimeControls:
    """What the user does with time.

    Args:
        server: viser's server.
        viewer: loop that runs the session.
    """

    def __init__(self, server: Any, viewer: Viewer) -> None:
        self._server, self._viewer = server, viewer
        self._shown_seed = viewer.session.seed
        gui = server.gui
        with gui.add_folder("Time"):
            self._run = gui.add_button(_PAUSE, hint="Stop time, or let it go on.")
            self._step = gui.add_button("Single step", hint="Pause, and take one action.")
            self._speed = gui.add_dropdown("speed [s/s]", _SPEEDS, initial_value="1")
            self._seed = gui.add_number("seed", viewer.session.seed, min=0, max=2**31, step=1)
            self._reset = gui.add_button("Reset", hint="Start the episode of this seed.")
            self._next = gui.add_checkbox("go on with the next seed", viewer.next_seed)
            self._camera = gui.add_button_group("camera", tuple(CAMERAS))
        self._run.on_click(lambda _: viewer.wish(self._toggle))
        self._step.on_click(lambda _: viewer.wish(self._take_step))
        self._reset.on_click(lambda _: viewer.wish(lambda: viewer.session.reset(int(self._seed.value))))
        self._speed.on_update(lambda _: viewer.wish(self._set_speed))
        self._next.on_update(lambda _: viewer.wish(self._set_next))
        self._camera.on_click(lambda _: self._look(str(self._camera.value)))

    def refresh(self) -> None:
        """Show what the button would do, and the seed of an episode that has begun."""
        if self._shown_seed != self._viewer.session.seed:
            self._shown_seed = self._seed.value = self._viewer.session.seed
        label = _PAUSE if self._viewer.session.running else _RUN
        if self._run.label != label:
            self._run.label = label

    def _toggle(self) -> None:
        session = self._viewer.session
        if session.running:
            session.pause()
            return
        if session.over:
            session.reset(session.seed + 1 if self._viewer.next_seed else session.seed)
        session.resume()

    def _take_step(self) -> None:
        self._viewer.session.pause()
        self._viewer.session.step()

    def _set_speed(self) -> None:
        self._viewer.real_time.speed = float(self._speed.value)
        self._viewer.real_time.start()

    def _set_next(self) -> None:
        self._viewer.next_seed = bool(self._next.value)

    def _look(self, name: str) -> None:
        """Move the cameras of all browsers."""
        for client in self._server.get_clients().values():
            look(client, name, self._viewer.session.inner.physics.tip_position[0].copy())
