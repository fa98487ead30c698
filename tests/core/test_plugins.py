"""Plugins: found, loaded once, digested, and reported with file and line when they fail."""

import pickle
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path

import pytest
from typer.testing import CliRunner

import prp_gym.plugins as plugins
from prp_gym.baselines import CONTROLLERS
from prp_gym.cli.main import app
from prp_gym.errors import PluginError
from prp_gym.plugins import digest_module, load_modules, load_plugins, loaded_plugins
from prp_gym.runs.code import running_code
from prp_gym.runs.workers import Workers

CONTROLLER = '''
"""A plugin with a controller."""

import prp_gym
from prp_gym.baselines import register_controller


@register_controller
@prp_gym.controller(name="plugged_in", summary="a damper that a plugin declares")
def damper(joint_velocity, *, damping=5.0):
    return -damping * joint_velocity
'''


@pytest.fixture(autouse=True)
def clean(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """No plugin of another test, and a current folder of the test's own."""
    monkeypatch.setattr(plugins, "_loaded", {})
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.chdir(tmp_path)
    before = set(sys.modules)
    yield
    for name in set(sys.modules) - before:
        if name.startswith("plug_"):
            del sys.modules[name]


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def test_module_of_the_current_folder_is_loaded_once(tmp_path: Path) -> None:
    write(tmp_path, "plug_counts.py", "import plug_log\nplug_log.loads.append(1)\n")
    write(tmp_path, "plug_log.py", "loads = []\n")
    for _ in range(2):
        assert load_plugins(["plug_counts"]) == ["plug_counts"]
    assert sys.modules["plug_log"].loads == [1]
    assert loaded_plugins() == {"plug_counts": digest_module("plug_counts")}


def test_installed_packages_of_the_group_are_loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, "plug_installed/__init__.py", "")
    write(tmp_path, "plug_installed/declared.py", "value = 3\n")
    entries = EntryPoints([EntryPoint("mine", "plug_installed.declared", plugins.GROUP)])
    monkeypatch.setattr(plugins, "entry_points", lambda group: entries.select(group=group))
    assert load_plugins() == ["plug_installed.declared"]
    assert sys.modules["plug_installed.declared"].value == 3
    assert plugins.GROUP == "prp_gym.plugins"


def test_import_of_the_suite_loads_no_plugin(tmp_path: Path) -> None:
    info = tmp_path / "plug_any-1.0.dist-info"
    write(info, "METADATA", "Metadata-Version: 2.1\nName: plug-any\nVersion: 1.0\n")
    write(info, "entry_points.txt", "[prp_gym.plugins]\nany = plug_any\n")
    write(tmp_path, "plug_any.py", "print('loaded')\n")
    root = str(Path(plugins.__file__).parents[1])
    code = f"import sys; sys.path[:0] = [{root!r}, {str(tmp_path)!r}]; import prp_gym; print('imported')"
    code += "\nfrom prp_gym.plugins import load_plugins; print(load_plugins())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split("\n")[:3] == ["imported", "loaded", "['plug_any']"]


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("x = 1\n\nraise ValueError('two\\nlines')\n", 3, "ValueError: two lines"),
        ("x = 1\ny = = 2\n", 2, "SyntaxError: invalid syntax"),
        ("import nothing_of_the_kind\n", 1, "ModuleNotFoundError: No module named 'nothing_of_the_kind'"),
        ("import json\n\njson.loads('{')\n", 3, "JSONDecodeError: "),
        (
            CONTROLLER.replace("plugged_in", "joint_pd"),
            8,
            "InvalidValueError: name of baseline is 'joint_pd'",
        ),
    ],
)
def test_plugin_that_fails_is_reported_with_its_line(
    tmp_path: Path, text: str, line: int, reason: str
) -> None:
    path = write(tmp_path, "plug_fails.py", text)
    with pytest.raises(PluginError) as caught:
        load_modules(["plug_fails"])
    error = pickle.loads(pickle.dumps(caught.value))
    assert (error.name, error.file, error.line) == ("plug_fails", str(path), line)
    assert error.reason.startswith(reason)
    assert str(error).startswith(f"plugin 'plug_fails' cannot be loaded: {path}, line {line}: {reason}")
    assert loaded_plugins() == {}


@pytest.mark.parametrize("name", ["plug_nowhere", "plug_nowhere.inner"])
def test_plugin_that_does_not_exist_is_refused(name: str) -> None:
    with pytest.raises(PluginError, match="there is no module 'plug_nowhere', neither installed nor"):
        load_plugins([name])


def test_digest_of_the_running_code_covers_plugins(tmp_path: Path) -> None:
    write(tmp_path, "plug_digest/__init__.py", "")
    data = write(tmp_path, "plug_digest/gains.toml", "x = 1\n")
    before = running_code()
    load_plugins(["plug_digest"])
    after = running_code()
    assert after == {**before, "plugin plug_digest": digest_module("plug_digest")}
    data.write_text("x = 2\n")
    assert digest_module("plug_digest") != after["plugin plug_digest"]


def find_plugged_in(_: int) -> tuple[int, dict[str, str]]:
    return CONTROLLERS.find("plugged_in").revision, running_code()


def test_worker_processes_load_the_plugins_of_their_parent(tmp_path: Path) -> None:
    write(tmp_path, "plug_damper.py", CONTROLLER)
    load_plugins(["plug_damper"])
    try:
        found = [result for _, result in Workers(2).run(find_plugged_in, range(4))]
    finally:
        CONTROLLERS.unregister("plugged_in")
    assert found == [(1, running_code())] * 4


@pytest.mark.parametrize(
    "command", ["list", "evaluate", "compare", "tune", "train", "export", "ship", "reproduce"]
)
def test_every_command_takes_plugins(command: str) -> None:
    result = CliRunner().invoke(app, [command, "--plugin", "plug_nowhere"])
    assert isinstance(result.exception, PluginError)
