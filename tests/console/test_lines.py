"""Progress without a terminal: a line now and then, also while one long piece of work is under way."""

import math
import subprocess
import sys
import time
from pathlib import Path

import pytest

from prp_gym.console import lines
from prp_gym.console.activity import Activity
from prp_gym.console.lines import Lines
from prp_gym.console.progress import duration, time_left


class Clock:
    """A clock that stands still until it is set."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


def test_line_says_what_is_done_what_runs_and_how_long_it_will_take(clock: Clock) -> None:
    told = Lines(print, "evaluating", 2000, "episodes", clock=clock)
    told.advance(500)
    told.run([Activity("first"), Activity("second", 0.25)])
    clock.now += 80
    assert told.line == (
        "evaluating: 500 of 2,000 episodes (25 %), 1 min 20 s elapsed, about 4 min 0 s left; "
        "running: first, second (25 %)"
    )


def test_line_of_one_job_of_which_nothing_is_known_names_it_and_the_elapsed_time(clock: Clock) -> None:
    told = Lines(print, "evaluating", 1, "episodes", clock=clock)
    told.run([Activity("long")])
    clock.now += 26
    assert told.line == "evaluating: 0 of 1 episodes (0 %), 26 s elapsed; running: long"


def test_line_of_work_without_an_amount_has_the_elapsed_time_alone(clock: Clock) -> None:
    told = Lines(print, "drawing", clock=clock)
    clock.now += 3700
    assert told.line == "drawing: 1 h 1 min elapsed"


def test_line_names_three_of_many_pieces_of_work(clock: Clock) -> None:
    told = Lines(print, "tuning", clock=clock)
    told.run([Activity(name) for name in "abcde"])
    assert told.line.endswith("; running: a, b, c and 2 more")


def test_what_an_interrupted_run_has_done_does_not_count_as_fast_work(clock: Clock) -> None:
    told = Lines(print, "training", 1000, "steps", clock=clock)
    clock.now += 500  # of preparation
    told.begin(600)
    told.reach(700)
    clock.now += 10
    assert "10 s elapsed, about 30 s left" in told.line


def test_time_left_is_not_known_before_anything_is_done() -> None:
    assert math.isnan(time_left(10.0, 3.0, 3.0, 8.0))
    assert math.isnan(time_left(10.0, 3.0, 0.0, math.inf))
    assert time_left(10.0, 8.0, 3.0, 8.0) == 0.0


def test_durations_have_two_units_at_most() -> None:
    assert [duration(s) for s in (0.4, 59, 61, 3599, 3600, 100_000)] == [
        *("0 s", "59 s", "1 min 1 s", "59 min 59 s", "1 h 0 min", "27 h 46 min"),
    ]


def test_period_between_two_lines_leaves_room_below_30_s() -> None:
    assert lines.PERIOD <= 28.0


def test_lines_come_while_the_work_lasts_and_no_more_afterwards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lines, "PERIOD", 0.01)
    told: list[str] = []
    with Lines(told.append, "working"):
        for _ in range(1000):
            time.sleep(0.005)  # one long piece of work, which tells nothing itself
            if len(told) >= 3:
                break
    count = len(told)
    assert count >= 3
    time.sleep(0.05)
    assert len(told) == count


def test_closed_stream_ends_no_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lines, "PERIOD", 0.001)

    def broken(_: str) -> None:
        raise BrokenPipeError

    with Lines(broken, "working"):
        time.sleep(0.02)


LONG_JOB = """
import sys, time
from prp_gym.console import lines
from prp_gym.runs import evaluation_job
lines.PERIOD = 0.1
run = evaluation_job.EvaluationJob.run
def slowly(self, controllers):
    time.sleep(1.0)
    return run(self, controllers)
evaluation_job.EvaluationJob.run = slowly
task = ("-e", "PRP-Adaptive-v0", "-b", "joint_pd", "-s", "report", "-j", "1")
sys.argv = ["prp-gym", "evaluate", *task, "-o", sys.argv[1]]
from prp_gym.cli.main import main
main()
"""


def test_command_tells_of_a_long_job_on_standard_error_in_a_pipe(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LONG_JOB, str(tmp_path)], capture_output=True, text=True, check=True
    )
    assert "joint_pd" in done.stdout
    assert " elapsed" not in done.stdout
    told = [
        line for line in done.stderr.splitlines() if line.startswith("evaluating: 0 of 3 episodes (0 %), ")
    ]
    assert len(told) >= 3
    assert all(line.endswith(" elapsed; running: PRP-Adaptive-v0_report_joint_pd") for line in told)
