"""The page in a browser: what it shows is the session, and what a user does with it reaches the session."""

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from prp_gym.viewing.policy_catalogue import PolicyCatalogue
from prp_gym.viewing.viewer import Viewer
from tests.support.chromium import CHROMIUM, Tab, chromium
from tests.support.viewing_sessions import controller_session

pytest.importorskip("viser", reason="the extra `view` is not installed")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium on this machine")

TASK, CONTROLLER = "PRP-JointRegulation-v0", "joint_inverse_dynamics"
TEXT = "(document.body?.innerText ?? '')"
PATIENCE = 60.0  # s


def until(condition: Callable[[], bool]) -> None:
    """Wait until a condition of the session holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture
def served() -> Iterator[tuple[Viewer, str]]:
    """A viewer that runs in a thread of its own, and the address of its page."""
    from prp_gym.viewing.web.page import Page
    from prp_gym.viewing.web.server import serving

    viewer, closed = Viewer(controller_session(TASK, CONTROLLER)), threading.Event()
    with serving("127.0.0.1", 0, "prp_gym") as server:

        class ClosablePage(Page):
            def show(self, viewer: Viewer) -> bool:
                return super().show(viewer) and not closed.is_set()

        page = ClosablePage(server, viewer, PolicyCatalogue(TASK, 500.0, viewer.session.source))
        thread = threading.Thread(target=viewer.run, args=(page,), daemon=True)
        thread.start()
        try:
            yield viewer, f"http://127.0.0.1:{server.get_port()}"
        finally:
            closed.set()
            thread.join(PATIENCE)
            viewer.session.close()


def click_button(tab: Tab, label: str) -> None:
    find = f"[...document.querySelectorAll('button')].find(b => b.innerText.trim() === '{label}')"
    tab.wait_for(f"!!{find}")
    tab.evaluate(f"{find}.click()")


def open_tab(tab: Tab, label: str) -> None:
    tab.press(f"[...document.querySelectorAll('[role=tab]')].find(b => b.innerText === '{label}')", "Enter")


def test_user_moves_a_slider_takes_a_step_and_sees_the_plots(
    served: tuple[Viewer, str], tmp_path: Path
) -> None:
    viewer, address = served
    session = viewer.session
    with chromium(tmp_path / "profile") as tab:
        tab.open(address, 760, 600)  # where the panels leave little to draw by software
        tab.wait_for(f"{TEXT}.includes('Single step')")
        click_button(tab, "Pause")  # of the tab that is open at first
        until(lambda: not session.running)
        before = session.time
        click_button(tab, "Single step")
        until(lambda: session.time > before)
        assert session.time == pytest.approx(before + session.period)

        own = session.policy.settings.proportional_gain  # type: ignore[attr-defined]
        open_tab(tab, "Settings")
        tab.wait_for("document.querySelectorAll('[role=slider]').length > 0")
        for _ in range(5):
            tab.press("document.querySelectorAll('[role=slider]')[0]", "ArrowRight")
        name = session.parameters[0].name
        until(lambda: session.factors[name] == pytest.approx(1.05))
        gain = session.policy.settings.proportional_gain  # type: ignore[attr-defined]
        assert gain[0] == pytest.approx(own[0] * 1.05**2)  # the bandwidth of joint 1

        tab.wait_for("document.querySelectorAll('.uplot').length === 2")
        for shown in (TASK, f"seed {session.seed}", "paused", "Joint error", "joint 2 [m]"):
            tab.wait_for(f"{TEXT}.includes('{shown}')")
        open_tab(tab, "Run")
        click_button(tab, "Reset")
        until(lambda: session.time == 0.0)
