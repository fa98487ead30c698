"""Files are data: one reader of JSON, TOML and YAML files, the check of their types, and their checksums.

Every file that the package opens at run time goes through `FileReader`, whether a user or the package wrote
it. It opens regular files alone, up to a size, and takes plain values alone: text, numbers, true, false,
null, lists and mappings, of a limited depth. Nothing in a file is imported or run.
"""

from prp_gym.files.archive import check_archive
from prp_gym.files.checksum import checksum, seal, unseal, unseal_or_former
from prp_gym.files.file_reader import RECORD_SIZE, SETTINGS_SIZE, FileReader
from prp_gym.files.regular_file import open_regular
from prp_gym.files.typed_reader import TypedReader

__all__ = [
    "RECORD_SIZE",
    "SETTINGS_SIZE",
    "FileReader",
    "TypedReader",
    "check_archive",
    "checksum",
    "open_regular",
    "seal",
    "unseal",
    "unseal_or_former",
]
