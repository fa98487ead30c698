"""An optional package that is missing is named with the line that installs it."""

import sys
import tomllib
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import NoReturn

import pytest
from typer.testing import CliRunner

from prp_gym import extras
from prp_gym.cli.main import app
from prp_gym.errors import MissingPackageError

ROOT = Path(__file__).resolve().parents[2]
IMPORTED = {
    "torch": "agents",
    "stable_baselines3": "agents",
    "sb3_contrib": "agents",
    "tensorboard": "agents",
    "yaml": "agents",
    "optuna": "tune",
    "ray": "ray",
    "moviepy": "video",
}
"""Import names of the optional packages that commands use, with their extras."""


def test_extra_of_a_package_is_that_of_the_project_file() -> None:
    assert {package: extras.extra_of(package) for package in IMPORTED} == IMPORTED
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared = project["optional-dependencies"]
    for package, extra in IMPORTED.items():
        name = "pyyaml" if package == "yaml" else package.replace("_", "-")
        assert any(entry.startswith(f"{name}>") for entry in declared[extra])


def test_package_of_no_extra_is_installed_by_its_own_name() -> None:
    with pytest.raises(
        MissingPackageError, match=r"^no_such_package is not installed; .*: pip install no_such_package$"
    ):
        extras.require("no_such_package.module")


@pytest.mark.parametrize("package", IMPORTED)
def test_blocked_import_is_told_with_the_line_that_installs_it(
    package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    line = rf"^{package} is not installed; install it with: pip install 'prp-gym\[{IMPORTED[package]}\]'$"
    for call in (extras.require, extras.check):
        with pytest.raises(MissingPackageError, match=line):
            call(package)


def test_version_of_a_missing_package_is_told_likewise(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> NoReturn:
        raise PackageNotFoundError(name)

    monkeypatch.setattr(extras, "version", absent)
    with pytest.raises(MissingPackageError, match=r"pip install 'prp-gym\[tune\]'$"):
        extras.version_of("optuna")


def test_dependency_that_an_installed_package_lacks_is_not_taken_for_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def broken(_: str) -> NoReturn:
        raise ModuleNotFoundError("No module named 'pandas'", name="pandas")

    monkeypatch.setattr(extras, "import_module", broken)
    with pytest.raises(ModuleNotFoundError, match="pandas"):
        extras.require("torch")


TASK = "PRP-Adaptive-v0"


@pytest.mark.parametrize(
    ("package", "command"),
    [
        ("stable_baselines3", ("train", TASK)),
        ("yaml", ("train", TASK)),
        ("tensorboard", ("train", TASK)),
        ("optuna", ("tune", "joint_pd", "-e", TASK, "--budget", "20000")),
        ("ray", ("evaluate", "-e", TASK, "--backend", "ray")),
        ("stable_baselines3", ("export", "model.zip", "-e", TASK, "--trust")),
        ("yaml", ("zoo", "recipes.yml")),
    ],
    ids=lambda value: value if isinstance(value, str) else value[0],
)
def test_command_names_the_missing_package_with_the_line_that_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, package: str, command: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, package, None)
    output = () if command[0] == "zoo" else ("--output", "made")
    result = CliRunner().invoke(app, [*command, *output])
    assert isinstance(result.exception, MissingPackageError), result.output
    line = f"{package} is not installed; install it with: pip install 'prp-gym[{IMPORTED[package]}]'"
    assert str(result.exception) == line
    assert not list(tmp_path.rglob("*.json"))
