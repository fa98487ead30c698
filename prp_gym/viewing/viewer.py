"""`Viewer`: the loop that runs a session in real time, carries out what the user wants, and shows it."""

import queue
import time
from collections.abc import Callable
from typing import Protocol

from prp_gym.errors import PRPError
from prp_gym.viewing.real_time import RealTime
from prp_gym.viewing.session import Session

_FRAME = 1.0 / 30.0  # s of real time between frames


class Display(Protocol):
    """What shows a session."""

    def show(self, viewer: "Viewer") -> bool:
        """Show the present state; returns whether the display is still open."""

    def say(self, text: str) -> None:
        """Tell the user why something was refused or failed."""


class Viewer:
    """Runs a session in real time.

    What the user wants arrives from other threads; it is carried out between actions, in one thread.

    Args:
        session: session to run.

    Attributes:
        session: session that is running.
        real_time: relation of simulated to real time.
        next_seed: whether the episode of the next seed starts where one is over.
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.real_time = RealTime()
        self.next_seed = True
        self._wishes: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()

    def wish(self, action: Callable[[], None]) -> None:
        """Carry something out between two actions; to be called from any thread."""
        self._wishes.put(action)

    def run(self, display: Display) -> None:
        """Run until the display is closed."""
        self.real_time.start()
        following = time.monotonic()
        while self.turn(display):
            following = max(following + _FRAME, time.monotonic())
            time.sleep(max(0.0, following - time.monotonic()))

    def turn(self, display: Display) -> bool:
        """Carry out the user's wishes, take the actions that are due, and show the state.

        Returns:
            whether the display is still open.
        """
        self._guarded(display, self._carry_out)
        self._guarded(display, self._advance)
        return display.show(self)

    def _carry_out(self) -> None:
        while not self._wishes.empty():
            self._wishes.get()()

    def _advance(self) -> None:
        """Take the actions that are due."""
        session = self.session
        if not session.running:
            self.real_time.start()
            return
        taken = session.advance(self.real_time.due(session.period))
        self.real_time.taken(taken * session.period)
        if session.over and self.next_seed:
            session.reset(session.seed + 1)
        elif session.over:
            session.pause()

    def _guarded(self, display: Display, action: Callable[[], None]) -> None:
        """Do something; an error of this package stops time and is told to the user."""
        try:
            action()
        except PRPError as error:
            if action == self._advance:
                self.session.pause()
            display.say(str(error))
