"""CONTRIBUTING names every folder, and only folders that exist."""

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def named_folders() -> set[str]:
    """Folders in the first column of the table."""
    rows = [line.split("|")[1] for line in TEXT.splitlines() if line.startswith("| `")]
    return {name for cell in rows for name in re.findall(r"`([^`]+)/`", cell)}


def folders_of_code() -> set[str]:
    """Folders that hold tracked Python files, tests and examples as one."""
    listed = subprocess.run(["git", "ls-files", "*.py"], cwd=ROOT, capture_output=True, text=True, check=True)
    folders = {str(Path(name).parent) for name in listed.stdout.splitlines()}
    return {re.sub(r"^(tests|examples)/.*", r"\1", folder) for folder in folders}


def test_every_folder_of_code_is_named() -> None:
    unnamed = folders_of_code() - named_folders()
    assert unnamed <= {"agents"}  # an empty package around its parts


def test_named_folders_exist() -> None:
    assert [name for name in named_folders() if not (ROOT / name).is_dir() and name != "examples"] == []


def test_named_declarations_exist() -> None:
    import prp_gym

    for name in set(re.findall(r"`(register_\w+)\b", TEXT)):
        assert callable(getattr(prp_gym, name))


def test_named_files_exist() -> None:
    paths = set(re.findall(r"`([a-z_]+/[a-z_/]*[a-z_]+\.(?:py|toml|yml))`", TEXT))
    assert paths
    assert [path for path in paths if not (ROOT / path).exists()] == []
