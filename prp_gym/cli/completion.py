"""Names that a shell completes after an option.

Every function imports what it reads only when it is called, which a shell does as the user presses the key.
"""

from collections.abc import Iterable


def environments(incomplete: str) -> list[str]:
    """Ids of the environments that start with a text, in capitals or not."""
    from prp_gym.tasks.registration import list_envs

    return _starting(list_envs(), incomplete)


def controllers(incomplete: str) -> list[str]:
    """Names of the controllers that start with a text."""
    from prp_gym.baselines import CONTROLLERS

    return _starting(CONTROLLERS, incomplete)


def scenarios(incomplete: str) -> list[str]:
    """Names of the scenarios that start with a text."""
    from prp_gym.tasks.scenario import SCENARIOS

    return _starting(SCENARIOS, incomplete)


def gain_sets(incomplete: str) -> list[str]:
    """Names of the gain sets of all controllers that start with a text."""
    from prp_gym.baselines import CONTROLLERS

    return _starting(sorted({name for spec in CONTROLLERS.values() for name in spec.gain_sets}), incomplete)


def agents(incomplete: str) -> list[str]:
    """Names of the agents of the package that start with a text."""
    from prp_gym.agents.policy.agent_file import list_agents

    return _starting(list_agents(), incomplete)


def engines(incomplete: str) -> list[str]:
    """Names of the engines that start with a text."""
    from prp_gym.tasks.setup import ENGINES

    return _starting(ENGINES, incomplete)


def methods(incomplete: str) -> list[str]:
    """Names of the methods of a search that start with a text."""
    from prp_gym.tuning.task import METHODS

    return _starting(METHODS, incomplete)


def action_modes(incomplete: str) -> list[str]:
    """Names of the action modes that start with a text."""
    from prp_gym.action_modes import ACTION_MODES
    from prp_gym.baselines import CONTROLLERS

    names = ["torque"]
    for spec in ACTION_MODES.values():
        names += [f"{spec.name}:{name}" for name in CONTROLLERS] if spec.is_family else [spec.name]
    return _starting(names, incomplete)


def algorithms(incomplete: str) -> list[str]:
    """Names of the learning algorithms that start with a text."""
    from prp_gym.agents.algorithms import ALGORITHMS

    return _starting(ALGORITHMS, incomplete)


def backends(incomplete: str) -> list[str]:
    """Names of the backends of parallel workers that start with a text."""
    from prp_gym.runs.workers import BACKENDS

    return _starting(BACKENDS, incomplete)


def table_formats(incomplete: str) -> list[str]:
    """Names of the forms of tables that start with a text."""
    from prp_gym.tables.formats import FORMATS

    return _starting(FORMATS, incomplete)


def figure_formats(incomplete: str) -> list[str]:
    """Names of the kinds of figures that start with a text."""
    from prp_gym.figures.figure_file import SUFFIXES

    return _starting([suffix[1:] for suffix in SUFFIXES], incomplete)


def learning_ids(incomplete: str) -> list[str]:
    """Ids of the environments and their learning presets that start with a text."""
    from prp_gym.tasks.presets import learning_id
    from prp_gym.tasks.registration import list_envs

    return _starting((*list_envs(), *map(learning_id, list_envs())), incomplete)


def _starting(names: Iterable[str], incomplete: str) -> list[str]:
    """The names that start with a text, in capitals or not."""
    return [name for name in names if name.lower().startswith(incomplete.lower())]
