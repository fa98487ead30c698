"""The loop carries out wishes between actions, tells what was refused, and goes on with the next seed."""

import time

from prp_gym.viewing.viewer import Viewer
from prp_gym.viewing.window import key_action
from tests.support.viewing_sessions import SEED, controller_session

SPACE, RIGHT, UP, DOWN, BACKSPACE = 32, 262, 265, 264, 259


class Notes:
    """A display that keeps what it was told."""

    def __init__(self, turns: int = 10**9) -> None:
        self.texts: list[str] = []
        self.turns = turns

    def show(self, _: Viewer) -> bool:
        self.turns -= 1
        return self.turns > 0

    def say(self, text: str) -> None:
        self.texts.append(text)


def make_viewer() -> Viewer:
    return Viewer(controller_session("PRP-JointRegulation-v0", "joint_pd", "tuned_50hz", frequency=50.0))


def press(viewer: Viewer, notes: Notes, code: int) -> None:
    action = key_action(code, viewer)
    assert action is not None
    viewer.wish(action)
    viewer.turn(notes)


def test_refused_wish_is_told_and_time_goes_on() -> None:
    viewer, notes = make_viewer(), Notes()
    viewer.wish(lambda: viewer.session.choose_scenario("nowhere"))
    viewer.turn(notes)
    assert "did you mean" in notes.texts[0].lower() or "Valid: " in notes.texts[0]
    assert viewer.session.running


def test_runs_until_the_display_is_closed() -> None:
    viewer, notes = make_viewer(), Notes(turns=4)
    viewer.run(notes)
    assert notes.turns == 0
    assert viewer.session.time > 0.0


def test_end_of_an_episode_goes_on_with_the_next_seed_or_pauses() -> None:
    viewer, notes = make_viewer(), Notes()
    viewer.session.advance(10_000)
    viewer.turn(notes)
    assert (viewer.session.seed, viewer.session.over, viewer.session.running) == (SEED + 1, False, True)
    viewer.next_seed = False
    viewer.session.advance(10_000)
    viewer.turn(notes)
    assert (viewer.session.seed, viewer.session.over, viewer.session.running) == (SEED + 1, True, False)


def test_keys_pause_step_change_the_speed_and_reset() -> None:
    viewer, notes = make_viewer(), Notes()
    press(viewer, notes, SPACE)
    assert not viewer.session.running
    before = viewer.session.time
    press(viewer, notes, RIGHT)
    assert viewer.session.time == before + viewer.session.period
    press(viewer, notes, UP)
    press(viewer, notes, UP)
    press(viewer, notes, DOWN)
    assert viewer.real_time.speed == 2.0
    press(viewer, notes, BACKSPACE)
    assert viewer.session.time == 0.0
    press(viewer, notes, SPACE)
    assert viewer.session.running
    assert key_action(ord("Q"), viewer) is None


def test_failing_policy_stops_time_and_is_told() -> None:
    viewer, notes = make_viewer(), Notes()
    viewer.session.policy.predict = lambda *_, **__: None  # type: ignore[method-assign, assignment]
    time.sleep(1.5 * viewer.session.period)  # so that an action is due
    viewer.turn(notes)
    assert "predict" in notes.texts[0]
    assert not viewer.session.running
