"""Who may import whom: a short table, and learning libraries in agents alone."""

import ast
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import prp_gym

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = {
    "prp_gym": "prp_gym",
    "envs": "prp_gym.envs",
    "baselines": "prp_gym.baselines",
    "agents": "prp_gym.agents",
}
"""Folder in the repository, and the name under which it is imported."""

CORE_PACKAGES = (
    *(
        "errors",
        "nearest",
        "extras",
        "symbolic",
        "checks",
        "registry",
        "artifacts",
        "files",
        "plugins",
        "processes",
    ),
    *("robot", "palette", "drawing", "physics", "tasks", "tables", "figures", "evaluation"),
)
"""They import each other alone."""

MAY_IMPORT: dict[str, tuple[str, ...]] = {
    "envs": (),
    "baselines": (),
    "agents": ("envs",),
    "exporting": ("baselines",),
    "gradients": ("envs",),
    "linearization": ("envs",),
    "action_modes": ("envs", "baselines"),
    "tuning": ("baselines", "gradients"),
    "reproduction": ("baselines",),
    "prebuilding": ("envs", "baselines"),
    "console": (),
    "runs": ("envs", "baselines", "agents", "tuning", "console"),
    "recording": ("envs", "runs"),
    "comparison": ("envs", "baselines", "agents", "tuning", "runs"),
    "viewing": ("envs", "baselines", "agents", "tuning", "reproduction", "runs"),
    "cli": (
        *("envs", "baselines", "agents", "linearization", "gradients", "action_modes", "tuning"),
        *(
            "reproduction",
            "console",
            "exporting",
            "prebuilding",
            "runs",
            "recording",
            "comparison",
            "viewing",
        ),
    ),
}
"""What every other package imports beside the core; `prp_gym/__init__.py` passes names of all packages on."""

LEARNING = "agents"  # alone imports the learning libraries, whichever
BARE_NAMES = {name for name in PACKAGES if name != "prp_gym"}
PACKAGE_NAMES = {*CORE_PACKAGES, *MAY_IMPORT}
THIRD_PARTY = {"gymnasium", "numpy", "mujoco"}
MORE_THIRD_PARTY = {
    "cli": {"typer"},
    "comparison": {"matplotlib"},
    "console": {"rich"},
    "figures": {"matplotlib"},
    "files": {"yaml"},
    "prebuilding": {"typer"},
    "recording": {"PIL", "imageio_ffmpeg"},
    "reproduction": {"matplotlib"},
    "runs": {"cloudpickle", "joblib", "ray"},
    "tables": {"pandas", "rich"},
    "tuning": {"optuna"},
    "viewing": {"rich", "viser"},
}


def package(module: str) -> str:
    """The package of a module below `prp_gym`; empty for `prp_gym` itself."""
    return module.partition(".")[2].partition(".")[0]


def may_import(importer: str, imported: str) -> bool:
    """Whether a package may import another one; the facade may import them all."""
    return not importer or imported in (importer, *CORE_PACKAGES, *MAY_IMPORT.get(importer, ()))


def imported_modules(source: str, module: str, is_package: bool) -> Iterator[str]:
    """Absolute names of all that a module imports, wherever in the file."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            origin = node.module or ""
            if node.level:
                parents = module.split(".") if is_package else module.split(".")[:-1]
                package = parents[: len(parents) - node.level + 1]
                origin = ".".join([*package, *filter(None, [node.module])])
            yield origin
            for alias in node.names:
                yield f"{origin}.{alias.name}"
                if origin == "prp_gym":  # what the facade passes on
                    yield str(getattr(getattr(prp_gym, alias.name, None), "__module__", origin))
        elif isinstance(node, ast.Call):
            function = node.func.attr if isinstance(node.func, ast.Attribute) else ast.unparse(node.func)
            named = [value.value for value in node.args[:1] if isinstance(value, ast.Constant)]
            if function in {"import_module", "__import__"}:
                yield from (name for name in named if isinstance(name, str))


def violations(source: str, module: str, is_package: bool = False) -> set[str]:
    """What a module imports against the rule."""
    found = set()
    own = package(module)
    third_party = THIRD_PARTY | MORE_THIRD_PARTY.get(own, set())
    for name in imported_modules(source, module, is_package):
        top = name.partition(".")[0]
        upward = top == "prp_gym" and package(name) in PACKAGE_NAMES and not may_import(own, package(name))
        foreign = top != "prp_gym" and top not in sys.stdlib_module_names
        if upward or top in BARE_NAMES or (foreign and own != LEARNING and top not in third_party):
            found.add(name)
    return found


def modules() -> dict[str, Path]:
    """Every module of the suite by its import name; the links inside prp_gym are not followed."""
    found = {}
    for folder, package in PACKAGES.items():
        for root, _, names in os.walk(ROOT / folder, followlinks=False):
            for name in names:
                if name.endswith(".py"):
                    path = Path(root) / name
                    inner = path.relative_to(ROOT / folder).with_suffix("").parts
                    found[".".join([package, *(step for step in inner if step != "__init__")])] = path
    return found


MODULES = modules()


def test_modules_import_only_what_their_layer_may() -> None:
    assert {
        (module, name)
        for module, path in MODULES.items()
        for name in violations(path.read_text(encoding="utf-8"), module, path.name == "__init__.py")
    } == set()


def test_every_package_is_in_the_table() -> None:
    assert {package(module) for module in MODULES} - {""} == PACKAGE_NAMES
    assert len(set(MODULES.values())) == len(MODULES)


def test_loose_modules_are_few() -> None:
    loose = {module for module in MODULES if module.count(".") == 1 and MODULES[module].name != "__init__.py"}
    assert {package(module) for module in loose} == {
        *("artifacts", "checks", "errors", "extras", "nearest", "palette", "plugins", "registry"),
    }


CORE, ENVS, BASELINES, AGENTS = "prp_gym.tasks.x", "prp_gym.envs.x", "prp_gym.baselines.x", "prp_gym.agents.x"


@pytest.mark.parametrize(
    ("module", "source", "culprit"),
    [
        (CORE, "import prp_gym.envs.core.loop", "prp_gym.envs.core.loop"),
        (CORE, "from prp_gym.envs import loop", "prp_gym.envs"),
        (CORE, "from prp_gym import envs", "prp_gym.envs"),
        (CORE, "from prp_gym import make_baseline", "prp_gym.baselines.base.make"),
        (CORE, "from ..baselines import registry", "prp_gym.baselines.registry"),
        (CORE, "from .. import agents", "prp_gym.agents"),
        (CORE, "def f():\n    import prp_gym.baselines", "prp_gym.baselines"),
        (CORE, "from importlib import import_module\nimport_module('prp_gym.envs')", "prp_gym.envs"),
        (CORE, "import importlib\nimportlib.import_module('torch.nn')", "torch.nn"),
        (CORE, "from prp_gym.cli.main import app", "prp_gym.cli.main"),
        (CORE, "from prp_gym.runs.job import Job", "prp_gym.runs.job"),
        (CORE, "import joblib", "joblib"),
        (CORE, "import torch", "torch"),
        (CORE, "import scipy.linalg as la", "scipy.linalg"),
        (CORE, "from rich.table import Table", "rich.table"),
        (CORE, "import envs", "envs"),
        (CORE, "from prp_gym.reproduction import judge", "prp_gym.reproduction"),
        (CORE, "from matplotlib.figure import Figure", "matplotlib.figure"),
        (BASELINES, "import prp_gym.reproduction.run", "prp_gym.reproduction.run"),
        ("prp_gym.reproduction.run", "from prp_gym.cli.main import app", "prp_gym.cli.main"),
        ("prp_gym.reproduction.run", "import prp_gym.agents.load", "prp_gym.agents.load"),
        ("prp_gym.tuning.tune", "import matplotlib", "matplotlib"),
        ("prp_gym.evaluation.table", "import typer", "typer"),
        (BASELINES, "from prp_gym.tuning import tune", "prp_gym.tuning"),
        (
            "prp_gym.tuning.tune",
            "import prp_gym.agents.policy.agent_file",
            "prp_gym.agents.policy.agent_file",
        ),
        ("prp_gym.tuning.tune", "from prp_gym.runs.job import running_code", "prp_gym.runs.job"),
        ("prp_gym.runs.run", "import optuna", "optuna"),
        (ENVS, "from prp_gym.action_modes import list_action_modes", "prp_gym.action_modes"),
        (BASELINES, "import prp_gym.action_modes.catalogue", "prp_gym.action_modes.catalogue"),
        (AGENTS, "import prp_gym.action_modes.catalogue", "prp_gym.action_modes.catalogue"),
        ("prp_gym.action_modes.x", "import prp_gym.agents.load", "prp_gym.agents.load"),
        ("prp_gym.action_modes.x", "from prp_gym.cli.main import app", "prp_gym.cli.main"),
        ("prp_gym.action_modes.x", "import torch", "torch"),
        (ENVS, "from prp_gym.baselines.policy import Baseline", "prp_gym.baselines.policy"),
        (ENVS, "import prp_gym.agents", "prp_gym.agents"),
        (ENVS, "from stable_baselines3 import PPO", "stable_baselines3"),
        (ENVS, "from envs.loop import EpisodeLoop", "envs.loop"),
        (BASELINES, "import prp_gym.agents.train", "prp_gym.agents.train"),
        (BASELINES, "import sb3_contrib", "sb3_contrib"),
        (BASELINES, "from prp_gym.envs.core.loop import EpisodeLoop", "prp_gym.envs.core.loop"),
        (AGENTS, "from prp_gym.baselines import registry", "prp_gym.baselines"),
        (AGENTS, "from baselines import registry", "baselines"),
        (AGENTS, "import agents", "agents"),
        ("prp_gym", "import torch", "torch"),
        ("prp_gym.cli.main", "import stable_baselines3.ppo", "stable_baselines3.ppo"),
    ],
)
def test_checker_sees_a_violation(module: str, source: str, culprit: str) -> None:
    assert culprit in violations(source, module)


@pytest.mark.parametrize(
    ("module", "source"),
    [
        (
            CORE,
            "import os.path\nfrom collections.abc import Mapping\nimport numpy as np\nimport mujoco.batch",
        ),
        (CORE, "from prp_gym.robot import PRPArm\nfrom prp_gym import PRPError\nfrom .fields import Field"),
        (CORE, "name = 'import torch'  # import prp_gym.envs"),
        (
            ENVS,
            "from prp_gym.physics import Physics\nfrom prp_gym.envs import EnvConfig\nimport gymnasium",
        ),
        (BASELINES, "from prp_gym.tasks.fields import Field\nimport prp_gym.baselines.base.policy"),
        (AGENTS, "import torch\nfrom stable_baselines3 import PPO\nfrom prp_gym.envs import PRPEnv"),
        ("prp_gym", "from prp_gym.baselines.registry import make_baseline"),
        (
            "prp_gym.cli.main",
            "import typer\nfrom prp_gym.baselines import policy",
        ),
        ("prp_gym.tables.terminal", "from rich.table import Table"),
        ("prp_gym.figures.episode_figure", "def draw():\n    from matplotlib.lines import Line2D"),
        ("prp_gym.action_modes.x", "import prp_gym.envs.action_mode\nimport prp_gym.baselines.registry"),
        ("prp_gym.reproduction.run", "from prp_gym.baselines import make_baseline\nimport gymnasium"),
        ("prp_gym.reproduction.figures", "def draw():\n    from matplotlib.figure import Figure"),
        ("prp_gym.tuning.stored_study", "def search():\n    import optuna.storages.journal"),
        ("prp_gym.tuning.tune", "from prp_gym.baselines import make_baseline"),
    ],
)
def test_checker_lets_pass_what_is_allowed(module: str, source: str) -> None:
    assert violations(source, module) == set()


def test_checker_resolves_relative_imports_of_packages() -> None:
    assert violations("from . import registry", "prp_gym.baselines", is_package=True) == set()
    assert "prp_gym.agents" in violations("from .. import agents", "prp_gym.baselines", is_package=True)
