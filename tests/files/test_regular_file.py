"""Regular files alone are opened, up to a size, and nothing that would block is waited for."""

import os
import socket
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from prp_gym.errors import DataFileError, GainsFileError
from prp_gym.files.file_reader import SETTINGS_SIZE, FileReader
from prp_gym.files.regular_file import open_regular

READER = FileReader()


def make_pipe(path: Path) -> None:
    os.mkfifo(path)


def make_socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(str(path))


def make_sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(2**31)


OTHERS: dict[str, tuple[Callable[[Path], None], str]] = {
    "folder": (Path.mkdir, "is a directory; only a regular file is read"),
    "named pipe": (make_pipe, "is a named pipe; only a regular file is read"),
    "socket": (make_socket, "cannot be opened"),
    "/dev/zero": (lambda path: path.symlink_to("/dev/zero"), "is a device; only a regular file is read"),
    "/dev/full": (lambda path: path.symlink_to("/dev/full"), "is a device; only a regular file is read"),
    "/dev/stdin": (lambda path: path.symlink_to("/dev/tty"), "is a device|cannot be opened"),
    "loop of links": (lambda path: path.symlink_to(path), "cannot be opened"),
    "nothing": (lambda _: None, "cannot be opened: No such file"),
    "2 GB": (make_sparse, f"is larger than {SETTINGS_SIZE} bytes"),
}


@pytest.mark.parametrize("case", OTHERS)
def test_what_is_no_regular_file_of_a_fitting_size_is_refused_at_once(
    tmp_path: Path, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # the path of a socket has at most 107 characters
    path = Path("file.yml")
    make, message = OTHERS[case]
    make(path)
    for read in (READER.read_bytes, READER.read_yaml, READER.read_toml, READER.read_json):
        with pytest.raises(DataFileError, match=message) as caught:
            read(path)
        assert caught.value.path == str(path)


@pytest.mark.parametrize("name", ["a\0b", "a" * 5000, "\udcff"])
def test_path_that_no_file_has_is_refused(name: str) -> None:
    with pytest.raises(DataFileError, match="cannot be opened"):
        READER.read_bytes(Path(name))


def test_link_to_a_regular_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"a: 1")
    (tmp_path / "link").symlink_to("file")
    assert READER.read_yaml(tmp_path / "link") == {"a": 1}
    with open_regular(tmp_path / "link") as file:
        assert file.read() == b"a: 1"


def test_largest_size_is_allowed_and_one_byte_more_is_not(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"x" * 1000)
    assert len(FileReader(1000).read_bytes(path)) == 1000
    with pytest.raises(DataFileError, match="is larger than 999 bytes"):
        FileReader(999).read_bytes(path)


def test_refused_file_is_closed(tmp_path: Path) -> None:
    before = set(os.listdir("/proc/self/fd"))
    for _ in range(10):
        with pytest.raises(DataFileError):
            READER.read_bytes(tmp_path)
    assert len(set(os.listdir("/proc/self/fd")) - before) < 10


def test_writer_of_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    failures: list[DataFileError] = []

    def read() -> None:
        try:
            READER.read_bytes(tmp_path / "pipe")
        except DataFileError as error:
            failures.append(error)

    reader = threading.Thread(target=read, daemon=True)
    reader.start()
    reader.join(10.0)  # it takes microseconds
    assert failures


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"a: \xe9", "is not text in UTF-8: .* at byte 3"),
        (b"\xff\xfea\x00", "is not text in UTF-8"),
        (b"\xef\xbb\xbfa: 1", "begins with a byte order mark"),
        (b"\xed\xa0\x80", "is not text in UTF-8"),
    ],
)
def test_what_is_not_utf_8_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    (tmp_path / "file").write_bytes(content)
    for read in (READER.read_yaml, READER.read_toml, READER.read_json, READER.read_text):
        with pytest.raises(DataFileError, match=message):
            read(tmp_path / "file")


def test_error_is_of_the_class_that_the_reader_names(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    with pytest.raises(GainsFileError, match=r"^gains file '.*my\.toml': cannot be opened"):
        FileReader(100, GainsFileError).read_toml(path)
    path.write_text("a = = 1")
    with pytest.raises(GainsFileError, match=r"^gains file '.*my\.toml': cannot be read as TOML: "):
        FileReader(100, GainsFileError).read_toml(path)
