"""The journal of a search: damaged in any way, it is refused and left as it is, or read as it was."""

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from prp_gym.errors import DataFileError, InvalidValueError, PRPError
from prp_gym.tuning import StoredStudy
from prp_gym.tuning.journal import JOURNAL
from prp_gym.tuning.search_space import Parameter
from prp_gym.tuning.trial import Trial
from tests.support.damage import damaged


@dataclass(frozen=True)
class PlainSpace:
    """Two factors, and nothing to make of them."""

    parameters: tuple[Parameter, ...] = (
        Parameter("first", 0.1, 10.0, {"x": 1.0}, ...),
        Parameter("second", 0.5, 2.0, {"y": 1.0}, ...),
    )

    @property
    def start(self) -> dict[str, float]:
        return {item.name: 1.0 for item in self.parameters}

    def settings(self, factors: Any) -> dict[str, Any]:
        return dict(factors)


SPACE = PlainSpace()
KEY = {"made": "up", "numbers": [1, 2.5]}


def open_study(folder: Path) -> StoredStudy:
    return StoredStudy(folder, SPACE, KEY, 0, True)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, list[Any]]:
    """The content of a journal of four trials, written in two runs, and the trials."""
    folder = tmp_path_factory.mktemp("search")
    for _ in range(2):
        study = open_study(folder)
        for score in (0.25, 0.5):
            study.record(Trial(study.propose()[0], score, 10, 0.125, (score, 0.25)))
    return (folder / JOURNAL).read_bytes(), study.trials


def refused(folder: Path, content: bytes) -> str:
    """The message about a journal with this content, which must stay as it is."""
    (folder / JOURNAL).write_bytes(content)
    with pytest.raises(DataFileError) as caught:
        open_study(folder)
    assert (folder / JOURNAL).read_bytes() == content
    assert caught.value.path == str(folder / JOURNAL)
    return str(caught.value)


def test_damaged_journal_is_refused_or_read_as_it_was(
    tmp_path: Path, written: tuple[bytes, list[Any]]
) -> None:
    content, trials = written
    outcomes = []
    for number, damage in enumerate(damaged(content, 150)):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / JOURNAL).write_bytes(damage)
        try:
            found = open_study(folder).trials
        except PRPError:
            outcomes.append("refused")
            assert (folder / JOURNAL).read_bytes() == damage
            continue
        # a journal that ends within a line is that of a killed run
        assert found == trials or (content.startswith(damage) and found == trials[: len(found)])
        outcomes.append("read")
    assert outcomes.count("refused") > 60


def test_line_of_a_killed_run_is_taken_away_but_a_damaged_one_is_not(
    tmp_path: Path, written: tuple[bytes, list[Any]]
) -> None:
    content, trials = written
    (tmp_path / JOURNAL).write_bytes(content[:-1])  # without the end of its last line
    assert open_study(tmp_path).trials == trials[:3]
    assert "line 7, the last one, is damaged" in refused(tmp_path, content[:-1] + b"x")
    assert "the last one, is damaged" in refused(tmp_path, content + b"\xc3\xa4")


def change(number: int, **values: Any) -> Callable[[list[dict[str, Any]]], None]:
    return lambda lines: lines[number].update(values)


ALTERED: dict[str, Callable[[list[dict[str, Any]]], Any]] = {
    "study is deleted": lambda lines: lines.append({"op_code": 1, "worker_id": "w", "study_id": 0}),
    "another study": change(2, study_id=1),
    "another name": change(0, study_name="other"),
    "another direction": change(0, directions=[1]),
    "unknown operation": change(2, op_code=99),
    "no operation": lambda lines: lines[2].pop("op_code"),
    "waiting trial": change(2, state=4),
    "failed trial": change(2, state=3),
    "score as text": change(2, value="0.5"),
    "score as null": change(2, value=None),
    "other score": change(2, value=0.75),
    "other parameters": lambda lines: lines[2]["params"].update(third=1.0),
    "fewer parameters": lambda lines: lines[2]["params"].pop("first"),
    "parameter out of range": lambda lines: lines[2]["params"].update(first=1e9),
    "parameter as text": lambda lines: lines[2]["params"].update(first="os:system"),
    "other distribution": lambda lines: lines[2]["distributions"].update(first='{"name": "os"}'),
    "no distributions": change(2, distributions=None),
    "no attributes": change(2, user_attrs={}),
    "code as attribute": lambda lines: lines[2]["user_attrs"].update(run="os:system"),
    "steps as text": lambda lines: lines[2]["user_attrs"].update(steps="10"),
    "no checksum": lambda lines: lines[2]["user_attrs"].pop("checksum"),
    "scores as text": lambda lines: lines[2]["user_attrs"].update(by_scenario="0.5"),
    "no scores": lambda lines: lines[2]["user_attrs"].update(by_scenario=[]),
    "stopped as a number": lambda lines: lines[2]["user_attrs"].update(stopped=1),
    "other steps": lambda lines: lines[2]["user_attrs"].update(steps=11),
    "attribute of the study": lambda lines: lines[1].update(user_attr={"other": {}}),
    "key as text": lambda lines: lines[1].update(user_attr={"key": "text"}),
    "list as line": lambda lines: lines.__setitem__(2, []),  # type: ignore[call-overload]
}


@pytest.mark.parametrize("case", ALTERED)
def test_line_that_a_search_does_not_write_is_refused_with_its_number(
    tmp_path: Path, written: tuple[bytes, list[Any]], case: str
) -> None:
    lines = [json.loads(line) for line in written[0].splitlines()]
    ALTERED[case](lines)
    message = refused(tmp_path, "".join(json.dumps(line) + "\n" for line in lines).encode())
    assert "is damaged: " in message
    assert "It is left as it is" in message


def test_part_that_optuna_alone_reads_is_refused_with_its_reason(
    tmp_path: Path, written: tuple[bytes, list[Any]]
) -> None:
    lines = [json.loads(line) for line in written[0].splitlines()]
    lines[2]["datetime_start"] = "yesterday"
    message = refused(tmp_path, "".join(json.dumps(line) + "\n" for line in lines).encode())
    assert "Optuna cannot read it (ValueError: " in message


@pytest.mark.parametrize(
    "content", [b"[" * 100_000 + b"\n", b"\xff\n", b"null\n", b"9" * 5000 + b"\n", b"\n"]
)
def test_text_of_another_kind_is_refused(tmp_path: Path, content: bytes) -> None:
    refused(tmp_path, content)


def test_journal_that_is_no_regular_file_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / JOURNAL)
    with pytest.raises(DataFileError, match="is a named pipe"):
        open_study(tmp_path)


def test_search_of_another_key_is_refused(tmp_path: Path, written: tuple[bytes, list[Any]]) -> None:
    (tmp_path / JOURNAL).write_bytes(written[0])
    with pytest.raises(InvalidValueError, match="to resume one of"):
        StoredStudy(tmp_path, SPACE, {"made": "otherwise"}, 0, True)


def test_proposals_do_not_depend_on_the_checksums(tmp_path: Path, written: tuple[bytes, list[Any]]) -> None:
    (tmp_path / JOURNAL).write_bytes(written[0])
    study = open_study(tmp_path)
    np.testing.assert_array_equal(
        [list(trial.factors.values()) for trial in study.trials],
        [list(trial.factors.values()) for trial in written[1]],
    )
    assert all(set(trial.factors) == {"first", "second"} for trial in study.trials)
