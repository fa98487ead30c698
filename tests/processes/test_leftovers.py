"""Temporary files: those of ended processes are removed, those of living ones are not."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from prp_gym.artifacts import write_file
from prp_gym.errors import OutputError
from prp_gym.processes.leftovers import part_of, remove_leftovers
from tests.support.full_disk import room_for


def ended_process() -> int:
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid


def make_part(folder: Path, process: int) -> Path:
    path = folder / f".result.json.{process}.part"
    path.touch()
    return path


def test_files_and_folders_of_ended_processes_are_removed(tmp_path: Path) -> None:
    ended = ended_process()
    make_part(tmp_path, ended)
    (tmp_path / f".checkpoint.{ended}.part").mkdir()
    (tmp_path / f".checkpoint.{ended}.part" / "half").touch()
    make_part(tmp_path, os.getpid())
    for name in ("result.json", ".hidden", ".x.part", ".x.1a.part", "result.json.12.part"):
        (tmp_path / name).touch()
    remove_leftovers(tmp_path)
    found = {path.name for path in tmp_path.iterdir()}
    assert found == {"result.json", ".hidden", ".x.part", ".x.1a.part", "result.json.12.part"}


def test_file_of_a_living_process_stays_unless_it_is_older_than_the_process(tmp_path: Path) -> None:
    part = make_part(tmp_path, os.getppid())
    remove_leftovers(tmp_path)
    assert part.exists()
    before = time.time() - 10 * 365 * 86400  # of another process with the same number
    os.utime(part, (before, before))
    remove_leftovers(tmp_path)
    assert not part.exists()


def test_own_temporary_file_is_recognised(tmp_path: Path) -> None:
    part_of(tmp_path / "a.b.json").touch()
    remove_leftovers(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_missing_folder_has_no_leftovers(tmp_path: Path) -> None:
    remove_leftovers(tmp_path / "missing")


def test_full_disk_leaves_the_file_that_was_there(tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    write_file(path, b"old")
    with room_for(100), pytest.raises(OutputError) as caught:
        write_file(path, b"x" * 101)
    assert caught.value.path == str(path)
    assert "File too large" in caught.value.reason
    assert (path.read_bytes(), list(tmp_path.iterdir())) == (b"old", [path])
