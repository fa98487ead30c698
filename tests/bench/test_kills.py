"""`make kills` and the bench of orphans: an interruption each, and whether a fault would be noticed."""

import io
import json
import signal
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pytest
from rich.console import Console

from bench.kill_case import CASES, OUTPUT
from bench.kill_trial import KillTrial, run_to_end
from bench.kills import KillTally, kill_often, tally_table
from bench.orphans import seconds_of_orphans
from bench.tagged_process import TaggedProcess
from prp_gym.errors import InvalidValueError, UnknownNameError

needs_proc = pytest.mark.skipif(
    not Path("/proc/self/environ").exists(), reason="processes are found in /proc"
)


TUNE = replace(
    CASES["tune"],
    arguments=tuple("report" if word == "randomized" else word for word in CASES["tune"].arguments),
)
"""The search with a single episode for its validation, not a hundred."""


class Uninterrupted(NamedTuple):
    """An uninterrupted search: its working folder, and how long it took [s]."""

    folder: Path
    seconds: float


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Uninterrupted:
    folder, start = tmp_path_factory.mktemp("reference"), time.monotonic()
    _, wrong = run_to_end((*TUNE.arguments, "--output", OUTPUT), folder)
    assert wrong == []
    return Uninterrupted(folder, time.monotonic() - start)


@needs_proc
def test_killed_search_goes_on_to_the_same_end(reference: Uninterrupted, tmp_path: Path) -> None:
    """Killed after a share of its time, of which the start of the command takes more than half."""
    trial = KillTrial(TUNE, signal.SIGKILL, 0.8 * reference.seconds)
    assert trial.faults(reference.folder, tmp_path) == []


@needs_proc
def test_faults_are_noticed(reference: Uninterrupted, tmp_path: Path) -> None:
    original, folder = reference.folder, tmp_path / "run"
    result = next((original / OUTPUT).glob("*/result.json"))
    there = folder / result.relative_to(original)
    there.parent.mkdir(parents=True)
    content = json.loads(result.read_bytes())
    there.write_text(json.dumps(content | {"seconds": 0.0}))
    assert TUNE.differences(original, folder) == []
    there.write_text(json.dumps(content | {"score": 0.5}))
    assert TUNE.differences(original, folder) == [str(result.relative_to(original))]
    there.write_text('{"half')
    with pytest.raises(InvalidValueError, match=r"content of result\.json"):
        TUNE.differences(original, folder)


@needs_proc
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_workers_end_with_their_command(tmp_path: Path, number: signal.Signals) -> None:
    seconds, errors = seconds_of_orphans("evaluate", number, 1.0, tmp_path)
    assert seconds < 10.0  # 2 s on an idle machine; a build server runs other tests meanwhile
    if number == signal.SIGTERM:
        assert errors.strip().startswith("interrupted: ")
        assert len(errors.strip().splitlines()) == 1  # and nothing of the workers


@needs_proc
def test_descendants_are_found_after_their_parent_has_ended(tmp_path: Path) -> None:
    command = TaggedProcess(("--version",), tmp_path, {})
    assert command.wait(60.0) == 0
    assert command.seconds_to_end(10.0) < 10.0
    assert command.alive() == []
    command.close()


def test_unknown_command_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="evaluate"):
        kill_often("evaluat", 1, 0, Console(file=sys.stderr))


def test_table_counts_signals_and_faults() -> None:
    tally = KillTally("tune", 1.0, (signal.SIGKILL, signal.SIGTERM, signal.SIGKILL), ((), ("torn: x",), ()))
    written = io.StringIO()
    Console(width=150, file=written).print(tally_table([tally]))
    text = written.getvalue()
    assert "3 interruptions, 1 with a fault" in text
    assert [cell.strip() for cell in text.splitlines()[-2].split("│")[1:-1]] == ["tune", "1.0", "2", "1", "1"]
