"""Folders of runs: a new one for each, an unfinished one goes on, `latest` leads to the last."""

import os
from datetime import datetime
from pathlib import Path
from typing import Any, NoReturn

import pytest

from prp_gym.errors import InvalidValueError
from prp_gym.runs import result_folder
from prp_gym.runs.result_folder import LATEST, ResultFolder, latest_folder

JOBS: list[Any] = [{"episodes": 3}]


class Clock:
    """Stands for `datetime`, at one moment for ever."""

    @staticmethod
    def now() -> datetime:
        return datetime(2026, 1, 2, 3, 4, 5)


@pytest.fixture(autouse=True)
def somewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(result_folder, "datetime", Clock)
    return tmp_path


def choose(
    name: str = "", content: Any = JOBS, goes_on: bool = True, command: str = "evaluate"
) -> ResultFolder:
    return ResultFolder.choose(command, None, name, content, goes_on)


def finish(folder: ResultFolder) -> Path:
    with folder.in_use():
        (folder.path / "results.json").write_text("{}")
    return folder.path


def interrupt(folder: ResultFolder) -> Path:
    with pytest.raises(KeyboardInterrupt), folder.in_use():
        raise KeyboardInterrupt
    return folder.path


def test_new_folder_has_command_time_and_name() -> None:
    assert choose().path == Path("results/evaluate/2026-01-02_03-04-05")
    assert choose("my-gains").path == Path("results/evaluate/2026-01-02_03-04-05_my-gains")
    assert choose("my-gains").path == Path("results/evaluate/2026-01-02_03-04-05_2_my-gains")


def test_finished_run_is_never_chosen_again() -> None:
    first = finish(choose())
    assert choose().path != first
    assert finish(choose()) not in (first, choose().path)


def test_unfinished_run_goes_on_with_the_same_content_alone() -> None:
    first = interrupt(choose())
    assert choose().path == first
    assert choose(content=[{"episodes": 4}]).path != first
    assert choose("other").path != first
    assert choose(command="compare").path != first
    assert choose(goes_on=False).path != first


def test_unfinished_run_goes_on_after_others_and_is_then_finished() -> None:
    first = interrupt(choose())
    finish(choose(content=["other"]))
    assert finish(choose()) == first
    assert choose().path != first


def test_damaged_record_is_no_unfinished_run() -> None:
    first = interrupt(choose())
    for text in ("", "[]", '{"key": 1}'):
        (first / "run.json").write_text(text)
        assert choose().path != first


@pytest.mark.parametrize("linked", [True, False], ids=["link", "file"])
def test_latest_leads_to_the_last_run(monkeypatch: pytest.MonkeyPatch, linked: bool) -> None:
    def refuse(*_: Any, **__: Any) -> NoReturn:
        raise OSError("no links here")

    if not linked:
        monkeypatch.setattr(os, "symlink", refuse)
    assert latest_folder("evaluate") == Path("results/evaluate/latest")
    first, second = finish(choose()), finish(choose())
    assert first != second
    latest = Path("results/evaluate") / LATEST
    assert latest.is_symlink() == linked
    assert latest_folder("evaluate").resolve() == second.resolve()
    if not linked:
        assert latest.read_text() == f"{second.name}\n"
    assert not list(Path("results/evaluate").glob(".*"))


def test_text_file_never_leads_out_of_the_folder() -> None:
    Path("results/evaluate").mkdir(parents=True)
    Path("results/evaluate/latest").write_text("../../elsewhere\n")
    assert latest_folder("evaluate") == Path("results/evaluate/elsewhere")


def test_folder_that_the_user_names_is_used_as_it_is(tmp_path: Path) -> None:
    folder = ResultFolder.choose("evaluate", tmp_path / "mine", "", JOBS, goes_on=True)
    assert folder.path == tmp_path / "mine"
    with folder.in_use():
        pass
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["a/b", "..a b", "x" * 81, "é\n"])
def test_name_that_cannot_be_part_of_a_folders_name_is_refused(name: str) -> None:
    with pytest.raises(InvalidValueError, match="--name is "):
        choose(name)
    assert not Path("results").exists()


def test_name_beside_a_whole_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidValueError, match="only without --output"):
        ResultFolder.choose("evaluate", tmp_path, "mine", JOBS, goes_on=True)
