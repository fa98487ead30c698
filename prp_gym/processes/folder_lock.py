"""`FolderLock`: one command at a time in a folder."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from prp_gym.artifacts import prepare_folder
from prp_gym.errors import FolderInUseError, OutputError
from prp_gym.processes.leftovers import remove_leftovers
from prp_gym.processes.lock_holder import LockHolder

LOCK = ".lock"
"""Name of the lock file, which says who holds the lock."""

_LARGEST = 1 << 16  # bytes of a lock file


class FolderLock:
    """The right to write into a folder, which one process of this machine has at a time.

    The kernel holds the lock on an open file, so that it ends with its process, however that one ends. The
    file itself is removed when the lock is released; one that a killed process has left locks nothing.

    Args:
        folder: folder that is locked, which is made if it does not exist.
        name: name of the lock file.
    """

    def __init__(self, folder: Path, name: str = LOCK) -> None:
        self._folder = folder
        self._path = folder / name

    @contextmanager
    def hold(self) -> Iterator[None]:
        """Hold the lock until the block or this process ends; temporary files of ended processes are removed.

        Raises:
            FolderInUseError: another process holds the lock.
            OutputError: the folder cannot be made or written to.
        """
        made = not self._folder.exists()
        descriptor = self._acquire()
        try:
            remove_leftovers(self._folder)
            yield
        finally:
            if self._is_the_file(descriptor):
                with suppress(OSError):
                    self._path.unlink()  # before the lock ends, so that nobody else has it yet
            os.close(descriptor)
            if made:
                with suppress(OSError):  # it holds files
                    self._folder.rmdir()

    def _acquire(self) -> int:
        """Descriptor of the locked file, which is still the one of this name."""
        while True:
            prepare_folder(self._folder)
            try:
                descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o644)
            except OSError as error:
                raise OutputError(self._path, error) from error
            try:
                self._lock(descriptor)
                if self._is_the_file(descriptor):
                    return descriptor
            except BaseException:
                os.close(descriptor)
                raise
            os.close(descriptor)  # its holder has removed it meanwhile

    def _lock(self, descriptor: int) -> None:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if self._is_the_file(descriptor):
                os.ftruncate(descriptor, 0)
                os.write(descriptor, LockHolder.this_process().to_bytes())
        except BlockingIOError:
            holder = LockHolder.parse(os.pread(descriptor, _LARGEST, 0))
            raise FolderInUseError(self._folder, holder) from None
        except OSError as error:
            raise OutputError(self._path, error) from error

    def _is_the_file(self, descriptor: int) -> bool:
        """Whether an open file is the one that the lock's name stands for."""
        try:
            return os.path.samestat(os.fstat(descriptor), os.stat(self._path, follow_symlinks=False))
        except OSError:
            return False
