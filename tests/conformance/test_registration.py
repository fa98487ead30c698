"""The environment ids, and that Gymnasium finds them."""

import subprocess
import sys
from dataclasses import replace
from typing import Any

import gymnasium
import pytest

import prp_gym
from prp_gym.envs import PRPEnv
from prp_gym.errors import InvalidValueError
from prp_gym.tasks.presets import learning_id
from prp_gym.tasks.registration import register_environments, register_task
from prp_gym.tasks.spec import TASKS, TaskSpec

TIMEOUT = 120.0  # of a new interpreter that imports MuJoCo [s]


@pytest.fixture(params=TASKS.values(), ids=lambda entry: entry.id)
def entry(request: pytest.FixtureRequest) -> TaskSpec:
    assert isinstance(request.param, TaskSpec)
    return request.param


def run(code: str) -> str:
    """What a new interpreter prints; warnings are errors there too."""
    command = [sys.executable, "-W", "error", "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_tasks_and_their_presets_are_exactly_what_gymnasium_knows() -> None:
    known = [name for name, spec in gymnasium.registry.items() if str(spec.entry_point).startswith("prp_gym")]
    tasks = prp_gym.list_envs()
    assert sorted([*tasks, *map(learning_id, tasks)]) == sorted(known)
    assert len(set(known)) == len(known) > 0


def test_ids_are_named_and_versioned_alike(entry: TaskSpec) -> None:
    namespace, name, version = gymnasium.envs.registration.parse_env_id(entry.id)
    assert namespace is None
    assert name.startswith("PRP-")
    assert version is not None


def test_id_leads_to_its_own_environment(entry: TaskSpec) -> None:
    env = gymnasium.make(entry.id)
    inner = env.unwrapped
    assert isinstance(inner, PRPEnv)
    assert inner.task.environment_id == entry.id
    assert inner.spec is not None
    assert inner.spec.id == entry.id
    assert inner.task_spec is entry
    assert entry.summary
    assert entry.entry.compose.__doc__


def test_declarations_are_distinct() -> None:
    specs = list(TASKS.values())
    assert len({spec.summary for spec in specs}) == len({spec.numbers for spec in specs}) == len(specs)


def test_id_follows_from_the_name_of_the_file(entry: TaskSpec) -> None:
    name = entry.numbers.stem
    assert entry.id == f"PRP-{name.title().replace('_', '')}-v0"
    assert entry.numbers.with_suffix(".py").is_file()
    assert entry.entry.compose.__module__ == f"prp_gym.envs.tasks.{name}"


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"summary": "another task of the same id"}, "name of environment is 'PRP-Force-v0'"),
        ({"id": "PRP Force"}, "name of environment is 'PRP Force'"),
        ({"id": "PRP-New-v0", "revision": 0}, "revision of environment 'PRP-New-v0' is 0"),
    ],
)
def test_declaration_that_cannot_be_registered_is_refused(changes: dict[str, Any], what: str) -> None:
    before = list(TASKS), set(gymnasium.registry)
    with pytest.raises(InvalidValueError, match=what):
        register_task(replace(TASKS["PRP-Force-v0"], **changes))
    assert (list(TASKS), set(gymnasium.registry)) == before


def test_registering_again_changes_nothing() -> None:
    before = {entry.id: gymnasium.registry[entry.id] for entry in TASKS.values()}
    register_environments()  # Gymnasium warns when an id is overridden, and warnings are errors here
    assert all(gymnasium.registry[name] is spec for name, spec in before.items())


def test_list_is_the_callers_own() -> None:
    prp_gym.list_envs().clear()
    assert prp_gym.list_envs()


def test_make_finds_the_package_by_prefix_without_an_import() -> None:
    code = (
        "import gymnasium, sys; assert 'prp_gym' not in sys.modules\n"
        f"for name in {list(TASKS)}:\n"
        "    env = gymnasium.make(f'prp_gym:{name}', scenario='report')\n"
        "    env.reset(seed=0)\n"
        "    print(env.step(env.action_space.sample())[3], env.unwrapped.task.environment_id)\n"
    )
    assert run(code).splitlines() == [f"False {name}" for name in TASKS]


def test_importing_the_package_loads_neither_environments_nor_learning_libraries() -> None:
    heavy = ("prp_gym.envs", "prp_gym.baselines", "prp_gym.agents", "torch", "stable_baselines3", "typer")
    code = f"import sys, prp_gym; print(sorted(set(sys.modules) & set({heavy})))"
    assert run(code) == "[]"


def test_making_and_stepping_loads_no_learning_library() -> None:
    code = (
        "import sys, gymnasium, prp_gym\n"
        "for name in prp_gym.list_envs():\n"
        "    env = gymnasium.make(name)\n"
        "    env.reset(seed=0)\n"
        "    env.step(env.action_space.sample())\n"
        "print(sorted({name.split('.')[0] for name in sys.modules} & {'torch', 'stable_baselines3', 'rich'}))"
    )
    assert run(code) == "[]"
