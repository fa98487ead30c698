"""Contributions that follow the recipes of CONTRIBUTING, and the tree to which they are added."""

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]


@dataclass(frozen=True)
class Contribution:
    """The files of one contribution, which stand in this folder under their final names.

    Attributes:
        recipe: Heading of the recipe in CONTRIBUTING.
        name: Name of the declaration.
        folder: Folder of the repository to which the files are added.
        files: Names of the module and of its data file, if it has one.
    """

    recipe: str
    name: str
    folder: str
    files: tuple[str, ...]

    @property
    def paths(self) -> tuple[str, ...]:
        """Paths of the files in the repository."""
        return tuple(f"{self.folder}/{name}" for name in self.files)

    @property
    def line_count(self) -> int:
        """Number of lines of all files that are not blank."""
        texts = ((HERE / name).read_text(encoding="utf-8") for name in self.files)
        return sum(bool(line.strip()) for text in texts for line in text.splitlines())


TASK = Contribution("A task", "PRP-JointSine-v0", "envs/tasks", ("joint_sine.py", "joint_sine.toml"))
CONTROLLER = Contribution(
    "A controller", "joint_feedforward", "baselines", ("joint_feedforward.py", "joint_feedforward.toml")
)
ACTION_MODE = Contribution(
    "An action mode", "feedforward_offset", "prp_gym/action_modes/modes", ("feedforward_offset.py",)
)
ALGORITHM = Contribution("A learning algorithm", "a2c", "agents/algorithms", ("a2c.py", "a2c.yml"))
METRIC = Contribution("A metric", "peak_power", "prp_gym/evaluation/metrics", ("power.py",))
CONTRIBUTIONS = (TASK, CONTROLLER, ACTION_MODE, ALGORITHM, METRIC)


def copy_tracked_files(target: Path) -> list[str]:
    """Copy what git tracks into an empty folder, symbolic links as links.

    Args:
        target: Folder that is made if it does not exist.

    Returns:
        Paths of the copied files.
    """
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    paths = [path for path in listed.stdout.splitlines() if (ROOT / path).exists()]
    for path in paths:
        (target / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / path, target / path, follow_symlinks=False)
    return paths


def add(contribution: Contribution, tree: Path) -> None:
    """Add the files of a contribution to a copy of the repository.

    Raises:
        FileExistsError: a file of this name is there already.
    """
    for name, path in zip(contribution.files, contribution.paths, strict=True):
        with (tree / path).open("xb") as file:
            file.write((HERE / name).read_bytes())
