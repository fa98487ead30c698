"""What is installed is what is tracked, under the right names."""

import importlib.util
import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path, PurePosixPath

import pytest

from tests.support.tracked_files import BUILD, MAPPED, ROOT, copy_tree, expected_modules, tracked_files


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the tracked files."""
    return copy_tree(tmp_path_factory.mktemp("tree"))


@pytest.fixture(scope="module")
def built(tree: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A folder with a wheel built from the tree, and one with an sdist and the wheel built from it."""
    direct, through_sdist = tmp_path_factory.mktemp("direct"), tmp_path_factory.mktemp("sdist")
    subprocess.run([*BUILD, str(direct), "--wheel", str(tree)], check=True, capture_output=True)
    subprocess.run([*BUILD, str(through_sdist), str(tree)], check=True, capture_output=True)
    return {"tree": direct, "sdist": through_sdist}


@pytest.fixture(scope="module")
def wheels(built: dict[str, Path]) -> dict[str, set[str]]:
    """Contents of a wheel built from the tree, and of one built from its sdist."""
    return {origin: _contents(folder) for origin, folder in built.items()}


def _wheel(folder: Path) -> Path:
    (wheel,) = folder.glob("*.whl")
    return wheel


def _contents(folder: Path) -> set[str]:
    with zipfile.ZipFile(_wheel(folder)) as archive:
        return {name for name in archive.namelist() if ".dist-info/" not in name}


def _description(folder: Path) -> str:
    """The README in a wheel's metadata."""
    with zipfile.ZipFile(_wheel(folder)) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        metadata = archive.read(name).decode()
    assert "\nDescription-Content-Type: text/markdown\n" in metadata
    return metadata.partition("\n\n")[2]


def _sdist_files(folder: Path) -> set[str]:
    (sdist,) = folder.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        return {name.partition("/")[2] for name in archive.getnames()}


def test_an_sdist_holds_documentation_tests_examples_and_constraints(built: dict[str, Path]) -> None:
    own = {"bench", "docs", "examples", "tests"}
    single = {"CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "Makefile", "README.md", "constraints.txt"}
    expected = {str(path) for path in tracked_files() if path.parts[0] in own or str(path) in single}
    assert expected - _sdist_files(built["sdist"]) == set()


@pytest.mark.parametrize("origin", ["tree", "sdist"])
def test_the_readme_in_the_metadata_has_no_link_to_a_file(built: dict[str, Path], origin: str) -> None:
    text = _description(built[origin])
    targets = re.findall(r"\]\(([^)]*)\)", text)
    assert [target for target in targets if not target.startswith("https://")] == []
    assert "<img" not in text  # whose files are not there either


def test_the_readme_in_the_metadata_names_files_of_the_sdist(built: dict[str, Path]) -> None:
    links = re.findall(r"\[[^\]]+\]\((?!https?://)([^)#]+)\)", (ROOT / "README.md").read_text())
    text = _description(built["sdist"])
    assert links
    assert [link for link in links if f"(`{link}`)" not in text] == []
    assert set(links) - _sdist_files(built["sdist"]) == set()


def test_a_wheel_built_from_the_sdist_runs(built: dict[str, Path], tmp_path: Path) -> None:
    with zipfile.ZipFile(_wheel(built["sdist"])) as archive:
        archive.extractall(tmp_path)
    code = (
        "import gymnasium, prp_gym, sys;"
        "env = gymnasium.make('PRP-Force-v0');"
        "print(prp_gym.__file__, prp_gym.make_baseline('force_inner_position', env), env.reset(seed=1)[1])"
    )
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.startswith(str(tmp_path))


@pytest.mark.parametrize("origin", ["tree", "sdist"])
def test_a_wheel_holds_exactly_the_tracked_files(wheels: dict[str, set[str]], origin: str) -> None:
    assert wheels[origin] == expected_modules()


@pytest.mark.parametrize("origin", ["tree", "sdist"])
def test_a_wheel_claims_no_bare_name(wheels: dict[str, set[str]], origin: str) -> None:
    assert {name.split("/")[0] for name in wheels[origin]} == {"prp_gym"}


@pytest.mark.parametrize("name", MAPPED)
def test_mapped_folders_are_links_in_the_package(name: str) -> None:
    link = ROOT / "prp_gym" / name
    assert link.is_symlink()
    assert link.readlink() == Path("..") / name


@pytest.mark.parametrize("name", MAPPED)
def test_mapped_folders_are_importable_in_the_package_alone(name: str, tmp_path: Path) -> None:
    assert importlib.util.find_spec(f"prp_gym.{name}") is not None
    code = f"import importlib.util, sys; sys.exit(importlib.util.find_spec({name!r}) is not None)"
    assert subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=False).returncode == 0


def test_every_sub_package_is_listed() -> None:
    import tomllib

    listed = set(tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"])
    modules = {PurePosixPath(name) for name in expected_modules() if name.endswith(".py")}
    folders = {str(path.parent).replace("/", ".") for path in modules}
    assert listed == folders


def test_constraints_pin_every_direct_dependency() -> None:
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = [
        *project["dependencies"],
        *(d for extra in project["optional-dependencies"].values() for d in extra),
    ]
    names = {re.split(r"[\[<>=~! ]", item)[0].lower().replace("_", "-") for item in wanted} - {"prp-gym"}
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pinned = {line.split("==")[0].lower().replace("_", "-") for line in lines if "==" in line}
    assert names - pinned == set()
