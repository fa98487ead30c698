"""Who may import whom among agents: policy <- sb3 <- algorithms <- training."""

import ast
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "agents"
ORDER = ("policy", "sb3", "algorithms", "training")
LIBRARIES = {"torch", "stable_baselines3", "sb3_contrib", "yaml"}


def imported(path: Path) -> set[str]:
    """Absolute names of all modules that a file imports, wherever in the file."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add(str(node.module))
    return found


@pytest.mark.parametrize("folder", ORDER)
def test_folder_imports_only_those_before_it(folder: str) -> None:
    allowed = ORDER[: ORDER.index(folder) + 1]
    for path in (FOLDER / folder).glob("*.py"):
        own = {name.split(".")[2] for name in imported(path) if name.startswith("prp_gym.agents.")}
        assert own <= set(allowed), path


def test_policies_need_no_learning_library() -> None:
    roots = {name.split(".")[0] for path in (FOLDER / "policy").glob("*.py") for name in imported(path)}
    assert roots.isdisjoint(LIBRARIES)
    assert "numpy" in roots


def test_the_folders_are_all_there_are() -> None:
    assert {path.parent.name for path in FOLDER.glob("*/*.py")} == set(ORDER)
    assert [path.name for path in FOLDER.iterdir() if path.is_file()] == ["__init__.py"]
