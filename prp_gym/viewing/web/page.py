"""`Page`: the page that shows a session and takes what the user wants."""

import time
from typing import Any

import numpy as np

from prp_gym.viewing.plots import make_plots
from prp_gym.viewing.policy_catalogue import PolicyCatalogue
from prp_gym.viewing.session import Session
from prp_gym.viewing.viewer import Viewer
from prp_gym.viewing.web.cameras import CAMERAS, FIELD_OF_VIEW, look
from prp_gym.viewing.web.charts import Charts
from prp_gym.viewing.web.plant_controls import PlantControls
from prp_gym.viewing.web.policy_controls import PolicyControls
from prp_gym.viewing.web.scene import SceneView
from prp_gym.viewing.web.time_controls import TimeControls

_EVERY = 0.25  # s of real time between updates of the charts and of the controls
_NOTICE = 10.0  # s for which a notice stays
_PLOTS_WIDTH = 380  # pixels


class Page:
    """A page in the browser: the scene, the controls and the live plots.

    Args:
        server: viser's server.
        viewer: loop that runs the session.
        catalogue: policies that may be chosen.

    Attributes:
        policy: choice of the policy, and sliders for its settings.
    """

    def __init__(self, server: Any, viewer: Viewer, catalogue: PolicyCatalogue) -> None:
        self._server = server
        server.gui.configure_theme(control_width="medium", show_logo=False, show_share_button=False)
        server.initial_camera.position, server.initial_camera.look_at = CAMERAS["overview"]
        server.initial_camera.fov = FIELD_OF_VIEW
        server.on_client_connect(lambda client: look(client, "overview", np.zeros(3)))
        self._scene = SceneView(server.scene)
        self._status = server.gui.add_markdown("")
        tabs = server.gui.add_tab_group()
        with tabs.add_tab("Run"):
            self._time = TimeControls(server, viewer)
            self.policy = PolicyControls(server.gui, viewer, catalogue, tabs.add_tab("Settings"))
        with tabs.add_tab("Surface, disturbance"):
            self._plant = PlantControls(server.gui, viewer)
        panel = server.gui.add_panel()
        self._charts = Charts(server.gui, panel.add_tab("Live plots"))
        panel.dock_left()
        panel.set_width(_PLOTS_WIDTH)
        panel.expand()
        server.gui.main_panel.dock_right()
        self._notice = ""
        self._next = 0.0
        self._charted: tuple[object, ...] = ()

    def show(self, viewer: Viewer) -> bool:
        """Show the present state; the page stays open until the command ends."""
        now = time.monotonic()
        with self._server.atomic():
            self._scene.show(viewer.session)
        if now >= self._next:
            self._next = now + _EVERY
            self._refresh(viewer)
            self._show_charts(viewer.session)
        return True

    def _show_charts(self, session: Session) -> None:
        """Show the plots, unless nothing has changed since."""
        present = (session.inner, session.seed, session.time, session.policy, session.surface)
        if session.time > 0.0 and present != self._charted:
            self._charted = present
            self._charts.show(make_plots(session))

    def say(self, text: str) -> None:
        """Show a notice in every browser, and in the status until the next one."""
        self._notice = text
        for client in self._server.get_clients().values():
            client.add_notification("Refused", text, auto_close_seconds=_NOTICE, color="red")

    def _refresh(self, viewer: Viewer) -> None:
        self._time.refresh()
        self.policy.refresh()
        self._plant.refresh()
        text = status_text(viewer) + (f"\n\nLast refusal: {self._notice}" if self._notice else "")
        if self._status.content != text:
            self._status.content = text


def status_text(viewer: Viewer) -> str:
    """Environment, time, speed and score of a session, in Markdown."""
    session = viewer.session
    steps = max(1, round(session.time / session.period))
    lines = [
        f"**{session.inner.task.environment_id}**, scenario {session.scenario}, seed {session.seed}",
        f"{_state(session)} at {session.time:.2f} of {session.inner.duration:g} s;"
        f" mean reward of a step {session.total_reward / steps:.3f}",
        _speed_text(viewer),
    ]
    return "\n\n".join(line for line in lines if line)


def _state(session: Session) -> str:
    if session.diverged:
        return "diverged"
    if session.over:
        return "over"
    return "running" if session.running else "paused"


def _speed_text(viewer: Viewer) -> str:
    """The real-time factor, and whether the simulation cannot keep the chosen speed."""
    real_time = viewer.real_time
    if not viewer.session.running:
        return ""
    text = f"real-time factor {real_time.factor:.2f} (chosen {real_time.speed:g})"
    return f"{text}: **slower than chosen**, this machine is too busy" if real_time.falls_behind else text
