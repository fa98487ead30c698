"""What `import prp_gym` gives, and what it leaves alone."""

import json
import os
import subprocess
import sys
from typing import Any

import gymnasium
import pytest

import prp_gym
from prp_gym import envs
from prp_gym.baselines import BASELINES
from prp_gym.envs.base.tracking_starts import ReferenceSampler
from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.envs.loop_environment import LoopEnvironment
from prp_gym.errors import PRPError, UnknownNameError
from prp_gym.tasks.parts import ErrorFunction, Reference, StartSampler, World
from prp_gym.tasks.presets import learning_id
from prp_gym.tasks.registration import register_environments
from prp_gym.tasks.spec import TASKS

HEAVY = ("rich", "typer", "torch", "stable_baselines3", "matplotlib", "mujoco", "pinocchio")
DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL")
NAMES = (
    *("PRPArm", "PRPError", "RobotParameters", "evaluate", "list_baselines", "list_envs", "make_baseline"),
    *("make_sb3_vec_env", "list_agents", "load_agent", "controller", "register_controller", "ControllerSpec"),
    *("register_action_mode", "ActionModeSpec"),
    *("register_algorithm", "register_metric", "register_task"),
)


def in_fresh_python(code: str, **variables: str) -> Any:
    """What a new interpreter prints as JSON, with only these of the display's variables set."""
    environment = {name: value for name, value in os.environ.items() if name not in DISPLAYS} | variables
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


def test_documented_names_are_public() -> None:
    assert {*NAMES, "__version__"} <= set(prp_gym.__all__)
    assert len(set(prp_gym.__all__)) == len(prp_gym.__all__)


@pytest.mark.parametrize("name", prp_gym.__all__)
def test_public_name_exists(name: str) -> None:
    assert getattr(prp_gym, name) is not None


def test_star_import_gives_every_public_name() -> None:
    code = "import json\nfrom prp_gym import *\nprint(json.dumps(sorted(globals())))"
    assert set(prp_gym.__all__) <= set(in_fresh_python(code))


def test_unknown_attribute_is_refused_by_name() -> None:
    with pytest.raises(AttributeError, match="module 'prp_gym' has no attribute 'make_baselines'"):
        _ = prp_gym.make_baselines


def test_names_imported_on_use_are_those_of_their_modules() -> None:
    from prp_gym.agents.policy.agent_file import list_agents, load_agent
    from prp_gym.agents.sb3.make_vec_env import make_sb3_vec_env
    from prp_gym.baselines import list_baselines, make_baseline
    from prp_gym.evaluation.evaluate import evaluate

    assert prp_gym.evaluate is evaluate
    assert prp_gym.list_agents is list_agents
    assert prp_gym.list_baselines is list_baselines
    assert prp_gym.load_agent is load_agent
    assert prp_gym.make_baseline is make_baseline
    assert prp_gym.make_sb3_vec_env is make_sb3_vec_env
    assert prp_gym.list_baselines() == list(BASELINES)


def test_version_is_the_installed_one() -> None:
    code = (
        "import json, prp_gym; from importlib.metadata import version;"
        "print(json.dumps([prp_gym.__version__, version('prp-gym')]))"
    )
    module, installed = in_fresh_python(code)
    assert module == installed


def test_import_registers_every_environment_with_gymnasium() -> None:
    code = "import gymnasium, json, prp_gym; print(json.dumps(list(gymnasium.registry)))"
    registered = in_fresh_python(code)
    tasks = prp_gym.list_envs()
    assert {*tasks, *map(learning_id, tasks)} == {name for name in registered if name.startswith("PRP-")}
    assert prp_gym.list_envs() == list(TASKS)


def test_registering_again_changes_nothing() -> None:
    before = dict(gymnasium.registry)
    register_environments()
    assert dict(gymnasium.registry) == before


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_environment_and_controller_from_public_names_alone(environment_id: str) -> None:
    env = gymnasium.make(f"prp_gym:{environment_id}", duration=0.1)
    policy = prp_gym.make_baseline(prp_gym.list_baselines()[0], env, gains="report")
    evaluation = prp_gym.evaluate(policy, env, episodes=1)
    env.close()
    assert 0.0 < evaluation.score.value <= 1.0


def test_errors_are_caught_by_their_root() -> None:
    with pytest.raises(PRPError) as caught:
        gymnasium.make(prp_gym.list_envs()[0], scenario="no_such_scenario")
    assert isinstance(caught.value, UnknownNameError)


def test_import_is_light() -> None:
    code = "import json, sys, prp_gym; print(json.dumps(list(sys.modules)))"
    loaded = set(in_fresh_python(code))
    assert "prp_gym.robot" in loaded
    assert loaded.isdisjoint(HEAVY)


def test_environment_and_controller_need_neither_torch_nor_the_command_line_s_libraries() -> None:
    code = (
        "import gymnasium, json, sys, prp_gym;"
        "env = gymnasium.make(prp_gym.list_envs()[0], duration=0.1);"
        "prp_gym.evaluate(prp_gym.make_baseline(prp_gym.list_baselines()[0], env), env, 1);"
        "print(json.dumps(list(sys.modules)))"
    )
    assert set(HEAVY) & set(in_fresh_python(code)) == {"mujoco"}


def graphics(library: str | None, **variables: str) -> str | None:
    """MUJOCO_GL after the import, where the system's EGL library is this."""
    code = (
        f"import ctypes.util; ctypes.util.find_library = lambda name: {library!r};"
        "import json, os, prp_gym; print(json.dumps(os.environ.get('MUJOCO_GL')))"
    )
    found: str | None = in_fresh_python(code, **variables)
    return found


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux draws without a display through EGL")
@pytest.mark.parametrize(
    ("library", "variables", "expected"),
    [
        ("libEGL.so.1", {}, "egl"),
        (None, {}, None),
        ("libEGL.so.1", {"DISPLAY": ":0"}, None),
        ("libEGL.so.1", {"WAYLAND_DISPLAY": "wayland-0"}, None),
        ("libEGL.so.1", {"MUJOCO_GL": "osmesa"}, "osmesa"),
        ("libEGL.so.1", {"MUJOCO_GL": "glfw", "DISPLAY": ":0"}, "glfw"),
    ],
)
def test_frames_are_drawn_with_egl_where_there_is_no_display(
    library: str | None, variables: dict[str, str], expected: str | None
) -> None:
    assert graphics(library, **variables) == expected


@pytest.mark.parametrize("name", envs.__all__)
def test_name_of_the_environments_package_exists(name: str) -> None:
    assert getattr(envs, name).__name__ == name


def test_no_environment_or_task_class_is_deeper_than_three_of_ours() -> None:
    import importlib
    import inspect
    import pkgutil

    roots = (LoopEnvironment, EpisodeLoop, World, StartSampler, Reference, ErrorFunction, ReferenceSampler)
    modules = [
        importlib.import_module(found.name)
        for found in pkgutil.walk_packages(envs.__path__, f"{envs.__name__}.")
    ]
    kinds = {kind for module in modules for _, kind in inspect.getmembers(module, inspect.isclass)}
    chains = {
        kind: [base for base in kind.__mro__ if base.__module__.startswith("prp_gym")]
        for kind in kinds
        if issubclass(kind, roots)
    }
    assert len(chains) > 20
    assert {kind for kind, chain in chains.items() if len(chain) > 3} == set()
