"""Signals that end a command: it tells what was kept, and ends at once at the second one."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator

import pytest

from prp_gym.processes.interruption import SIGNALS, Interruption, interruptible, kept_if_interrupted, relisten


@pytest.fixture(autouse=True)
def none_ignored() -> Iterator[None]:
    """As a shell with job control starts commands; one without it lets them ignore SIGINT."""
    before = {number: signal.signal(number, signal.SIG_DFL) for number in SIGNALS}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", SIGNALS)
def test_first_signal_is_raised_and_the_handlers_are_those_of_before(number: signal.Signals) -> None:
    before = [signal.getsignal(own) for own in SIGNALS]
    with interruptible():
        with pytest.raises(Interruption) as caught:
            os.kill(os.getpid(), number)
        assert caught.value.exit_code == 128 + number
    assert [signal.getsignal(own) for own in SIGNALS] == before


def test_what_was_kept_is_told_from_the_inside_outwards() -> None:
    with (
        pytest.raises(Interruption) as caught,
        kept_if_interrupted(lambda: "two"),
        kept_if_interrupted(lambda: ""),
        kept_if_interrupted(lambda: "one"),
    ):
        raise Interruption(signal.SIGTERM)
    assert caught.value.message == "interrupted: one; two."
    assert Interruption(signal.SIGTERM).message.startswith("interrupted: nothing")


def test_ignored_signal_stays_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with interruptible():
            os.kill(os.getpid(), signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)


def test_handler_of_a_library_is_replaced_again_inside_the_block_alone() -> None:
    before = signal.getsignal(signal.SIGTERM)
    relisten()
    assert signal.getsignal(signal.SIGTERM) is before
    with interruptible():
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        relisten()
        with pytest.raises(Interruption):
            os.kill(os.getpid(), signal.SIGTERM)


def test_another_thread_runs_the_block_unchanged() -> None:
    seen = []

    def work() -> None:
        with interruptible():
            seen.append(signal.getsignal(signal.SIGTERM))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [signal.getsignal(signal.SIGTERM)]


STUBBORN = """
import os, signal, sys, time
from prp_gym.processes import interruption
interruption._GRACE = float(sys.argv[1])
with interruption.interruptible():
    try:
        os.kill(os.getpid(), signal.SIGTERM)
    except interruption.Interruption:
        if sys.argv[2] == "again":
            os.kill(os.getpid(), signal.SIGINT)
        time.sleep(60)
"""


@pytest.mark.parametrize(("grace", "then", "code"), [("60", "again", 130), ("0.1", "wait", 143)])
def test_cleanup_that_hangs_is_ended_by_a_second_signal_or_after_a_while(
    grace: str, then: str, code: int
) -> None:
    command = [sys.executable, "-c", STUBBORN, grace, then]  # SIGINT is not ignored
    done = subprocess.run(command, capture_output=True, text=True, timeout=50, check=False)
    assert done.returncode == code
    assert ("without cleaning up" in done.stderr) == (then == "wait")
    assert "Traceback" not in done.stderr
