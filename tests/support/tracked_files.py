"""The files that git tracks, a copy of them, and where they lie in a wheel."""

import subprocess
import sys
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).resolve().parents[2]
MAPPED = ("envs", "baselines", "agents")
BUILD = [sys.executable, "-m", "build", "--no-isolation", "--outdir"]
DATA_SUFFIXES = {".c", ".h", ".py", ".toml", ".typed", ".yml", ".json", ".safetensors"}


def tracked_files() -> list[PurePosixPath]:
    """Files that git tracks, symbolic links included."""
    listing = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [PurePosixPath(line) for line in listing.stdout.splitlines()]


def expected_modules() -> set[str]:
    """Where every tracked file of the package lies in a wheel."""
    expected = set()
    for path in tracked_files():
        if path.suffix not in DATA_SUFFIXES or path.parts[0] not in {"prp_gym", *MAPPED}:
            continue
        prefix = PurePosixPath("prp_gym") if path.parts[0] in MAPPED else PurePosixPath()
        expected.add(str(prefix / path))
    return expected


def copy_tree(folder: Path) -> Path:
    """Copy the tracked files to a folder."""
    for path in tracked_files():
        source, target = ROOT / path, folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_symlink():
            target.symlink_to(source.readlink())
        elif source.exists():
            target.write_bytes(source.read_bytes())
    return folder
