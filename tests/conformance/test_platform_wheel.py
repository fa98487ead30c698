"""A wheel with compiled libraries: for one kind of machine, whose compiler it makes unnecessary."""

import json
import os
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

from tests.support.compiler import needs_compiler
from tests.support.tracked_files import BUILD, ROOT, copy_tree, expected_modules

pytestmark = needs_compiler

ADAPTIVE, FORCE = "PRP-Adaptive-v0", "PRP-Force-v0"
"""The environment whose libraries the wheel has, the smallest one, and one whose it lacks."""

EVALUATE = f"""
import json, sys
sys.modules["ziglang"] = None  # which brings a compiler along
import gymnasium, numpy as np, prp_gym
from prp_gym.symbolic.compiler import compiles_by_default
found = {{"file": prp_gym.__file__, "compiles": compiles_by_default()}}
for engine in ("mujoco", "compiled"):
    keywords = {{"scenario": "realistic", "control_frequency": 250, "duration": 0.4}}
    env = gymnasium.make("{ADAPTIVE}", engine=engine, **keywords)
    own = prp_gym.evaluate(prp_gym.make_baseline("adaptive", env, gains="report"), env, episodes=2)
    found[engine] = [(each.reward.tobytes().hex(), each.torque.tobytes().hex()) for each in own.rollouts]
    env.reset(seed=0)
    found[engine + " loop"] = env.unwrapped.loop._compiled is not None
print(json.dumps(found))
"""
OTHER = f"""
import gymnasium, sys
sys.modules["ziglang"] = None
import prp_gym
env = gymnasium.make("{FORCE}")
env.reset(seed=0)
env.step(env.action_space.sample())
try:
    gymnasium.make("{FORCE}", engine="compiled")
except prp_gym.errors.CompilerError as error:
    print(error)
"""


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copy_tree(tmp_path_factory.mktemp("tree"))


@pytest.fixture(scope="module")
def libraries(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The libraries of one environment."""
    folder = tmp_path_factory.mktemp("libraries")
    command = [sys.executable, "-m", "prp_gym.prebuilding", "--env", ADAPTIVE, "--output", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    return folder


@pytest.fixture(scope="module")
def wheel(tree: Path, libraries: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    environment = {**os.environ, "PRP_GYM_LIBRARIES": str(libraries)}
    command = [*BUILD, str(folder), "--wheel", str(tree)]
    subprocess.run(command, check=True, capture_output=True, env=environment)
    (wheel,) = folder.glob("*.whl")
    return wheel


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("installed")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


def run(code: str, package: Path, cache: Path, *, compiler: bool) -> str:
    """What a program prints with a package, an empty folder of libraries, and with or without a compiler."""
    environment = {**os.environ, "PYTHONPATH": str(package), "PRP_GYM_CACHE": str(cache)}
    environment.pop("PRP_GYM_COMPILED", None)
    if not compiler:
        environment = {**environment, "PATH": "", "CC": ""}
    command = [sys.executable, "-c", code]
    done = subprocess.run(
        command, cwd=cache.parent, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_wheel_is_for_one_kind_of_machine_and_any_python(wheel: Path) -> None:
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    assert wheel.stem.split("-")[2:] == ["py3", "none", platform]
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/WHEEL"))
        assert "Root-Is-Purelib: false" in archive.read(name).decode()


def test_wheel_has_the_libraries_beside_the_tracked_files(wheel: Path, libraries: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        found = {name for name in archive.namelist() if ".dist-info/" not in name}
    added = {f"prp_gym/symbolic/prebuilt/{path.name}" for path in libraries.iterdir()}
    assert added
    assert found == expected_modules() | added


def test_folder_without_libraries_is_refused(tree: Path, tmp_path: Path) -> None:
    environment = {**os.environ, "PRP_GYM_LIBRARIES": str(tmp_path)}
    command = [*BUILD, str(tmp_path / "wheel"), "--wheel", str(tree)]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode != 0
    assert f"PRP_GYM_LIBRARIES={tmp_path}: no libraries" in done.stdout + done.stderr


def test_wheel_needs_no_compiler_and_gives_the_same_bits(installed: Path, tmp_path: Path) -> None:
    """At another control frequency, too, than that for which the libraries were built."""
    without = json.loads(run(EVALUATE, installed, tmp_path / "none", compiler=False))
    assert without["file"].startswith(str(installed))
    assert without["compiles"]
    assert without["mujoco loop"]
    assert without["compiled loop"]
    assert not (tmp_path / "none").exists()
    own = json.loads(run(EVALUATE, ROOT, tmp_path / "own", compiler=True))
    assert list((tmp_path / "own").glob("*.so"))
    for engine in ("mujoco", "compiled"):
        assert without[engine] == own[engine]


def test_environment_without_libraries_runs_with_mujoco_alone(installed: Path, tmp_path: Path) -> None:
    printed = run(OTHER, installed, tmp_path / "none", compiler=False)
    assert "install gcc or clang" in printed
