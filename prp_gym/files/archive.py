"""`check_archive`: archives of arrays that hold no more than their size shows."""

import zipfile
from pathlib import Path
from typing import BinaryIO

from prp_gym.errors import DataFileError


def check_archive(path: Path, file: BinaryIO, error: type[DataFileError] = DataFileError) -> None:
    """Refuse what is not a zip archive without compression, as NumPy and PyTorch write them.

    Args:
        path: path of the file, for messages.
        file: file that is open for reading; it is at its start afterwards.
        error: class of the error that is raised.

    Raises:
        DataFileError: a file that is no archive, or that would be larger once it is unpacked.
    """
    try:
        with zipfile.ZipFile(file) as archive:
            members = archive.infolist()
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError) as fault:
        raise error(path, f"is not an archive of arrays: {fault}") from fault
    if any(item.compress_type != zipfile.ZIP_STORED or item.flag_bits & 1 for item in members):
        raise error(path, "is a compressed or encrypted archive, which this package does not write")
    file.seek(0)
