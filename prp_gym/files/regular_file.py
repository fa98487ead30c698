"""`open_regular`: regular files alone are opened, never a device, pipe or folder that would block."""

import os
import stat
from io import BufferedReader
from pathlib import Path

from prp_gym.errors import DataFileError

_KINDS = (
    (stat.S_ISDIR, "a directory"),
    (stat.S_ISFIFO, "a named pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def open_regular(path: Path, error: type[DataFileError] = DataFileError) -> BufferedReader:
    """Open a regular file, or a link to one, to read its bytes.

    Args:
        path: path of the file.
        error: class of the error that is raised.

    Raises:
        DataFileError: a file that is missing, cannot be opened, or is not a regular one.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except (OSError, ValueError) as fault:  # a path with a null character is a ValueError
        raise error(path, f"cannot be opened: {reason_of(fault)}") from fault
    try:
        mode = os.fstat(descriptor).st_mode
        if not stat.S_ISREG(mode):
            kind = next((name for is_kind, name in _KINDS if is_kind(mode)), "of another kind")
            raise error(path, f"is {kind}; only a regular file is read")
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def read_bytes(path: Path, largest: int, error: type[DataFileError] = DataFileError) -> bytes:
    """The content of a regular file.

    Args:
        path: path of the file.
        largest: largest size of the file [bytes].
        error: class of the error that is raised.

    Raises:
        DataFileError: a file that cannot be read, is not a regular one, or is larger.
    """
    with open_regular(path, error) as file:
        try:
            size = os.fstat(file.fileno()).st_size
            content = file.read(largest + 1) if size <= largest else b""
        except OSError as fault:
            raise error(path, f"cannot be read: {reason_of(fault)}") from fault
    if max(size, len(content)) > largest:
        raise error(path, f"is larger than {largest} bytes, which no file of this kind is")
    return content


def reason_of(fault: Exception) -> str:
    """The reason of a failed call of the operating system."""
    return str(getattr(fault, "strerror", None) or fault)
