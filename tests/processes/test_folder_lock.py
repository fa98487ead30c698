"""One command at a time in a folder: who holds the lock is told, and a killed holder locks nothing."""

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from prp_gym.errors import FolderInUseError, OutputError
from prp_gym.processes.folder_lock import LOCK, FolderLock
from prp_gym.processes.lock_holder import LockHolder

HOLDER = """
import sys
from pathlib import Path
from prp_gym.processes.folder_lock import FolderLock
with FolderLock(Path(sys.argv[1])).hold():
    print("held", flush=True)
    sys.stdin.read()
"""


@contextmanager
def held_by_another_process(folder: Path) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-c", HOLDER, str(folder)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        try:
            yield holder
        finally:
            holder.kill()


def test_lock_is_refused_while_it_is_held_and_its_holder_is_told(tmp_path: Path) -> None:
    with held_by_another_process(tmp_path) as holder:
        with pytest.raises(FolderInUseError) as caught, FolderLock(tmp_path).hold():
            pass
        told = str(caught.value)
        assert f"folder {str(tmp_path)!r} is in use by process {holder.pid} on " in told
        assert str(tmp_path) in told.partition("since")[2]  # of the command line
        assert "--fresh" not in told
        holder.send_signal(signal.SIGKILL)
        holder.wait()
        assert (tmp_path / LOCK).exists()
        with FolderLock(tmp_path).hold():
            assert json.loads((tmp_path / LOCK).read_bytes())["process"] == os.getpid()
    assert list(tmp_path.iterdir()) == []


def test_locks_of_two_names_do_not_exclude_each_other(tmp_path: Path) -> None:
    with FolderLock(tmp_path).hold(), FolderLock(tmp_path, ".other.lock").hold():
        assert len(list(tmp_path.iterdir())) == 2


def test_only_one_of_many_has_the_lock_also_when_its_file_is_removed(tmp_path: Path) -> None:
    """A file that is removed while another process waits to lock it must not be locked by two."""
    inside, most, refused = [0], [0], [0]
    guard = threading.Lock()

    def work() -> None:
        for _ in range(100):
            try:
                with FolderLock(tmp_path).hold():
                    with guard:
                        inside[0] += 1
                        most[0] = max(most[0], inside[0])
                    with guard:
                        inside[0] -= 1
            except FolderInUseError:
                refused[0] += 1

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1]
    assert 0 < refused[0] < 400


def test_folder_that_was_made_for_the_lock_goes_with_it_and_others_stay(tmp_path: Path) -> None:
    with FolderLock(tmp_path / "new").hold():
        pass
    (tmp_path / "old").mkdir()
    with FolderLock(tmp_path / "old").hold():
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["old"]


def test_link_in_the_place_of_the_lock_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "precious").write_text("kept")
    (tmp_path / LOCK).symlink_to(tmp_path / "precious")
    with pytest.raises(OutputError), FolderLock(tmp_path).hold():
        pass
    assert (tmp_path / "precious").read_text() == "kept"


def test_file_in_the_place_of_the_folder_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="file"), FolderLock(tmp_path / "file").hold():
        pass


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"process": "x"}', b"[" * 100_000, b"\xff"])
def test_holder_of_whom_nothing_is_known_is_another_process(content: bytes) -> None:
    assert str(LockHolder.parse(content)) == "another process"


def test_holder_is_the_one_that_was_written() -> None:
    holder = LockHolder.this_process()
    assert LockHolder.parse(holder.to_bytes()) == holder
