"""The command `prp-gym export`."""

import shlex
import sys
from contextlib import closing
from pathlib import Path
from typing import Annotated, Any

import gymnasium
import typer

from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.agents.policy.agent_card import TrainingRecord
from prp_gym.agents.policy.agent_file import save_agent
from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.agents.training.export import AgentFacts, export_agent, identity_normalizer
from prp_gym.cli.options import (
    ActionMode,
    Algorithm,
    Json,
    KnownControlFrequency,
    KnownSeed,
    OneEnvironment,
    Output,
    Plugins,
    Scenarios,
    only,
)
from prp_gym.console.terminal import Terminal
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import InvalidValueError
from prp_gym.processes.folder_lock import FolderLock
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.presets import find_preset

_DEFAULT_SCENARIOS = ["randomized"]


def export_command(
    path: Annotated[Path, typer.Argument(help="Model of Stable-Baselines3, a zip.")],
    env: OneEnvironment,
    output: Output,
    algo: Algorithm = "ppo",
    normalizer: Annotated[
        Path | None, typer.Option(help="Pickle of the model's VecNormalize.", show_default="none was used")
    ] = None,
    scenario: Scenarios = _DEFAULT_SCENARIOS,
    action_mode: ActionMode = "torque",
    control_frequency: KnownControlFrequency = None,
    seed: KnownSeed = None,
    trust: Annotated[
        bool, typer.Option("--trust", help="Open the files, and run whatever code is in them.")
    ] = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Convert a model of Stable-Baselines3 into an agent's files, which hold no code.

    The options name what the agent was trained on: the task or its learning preset, scenario, action mode,
    control frequency (that of the id by default) and seed (that of the model by default). --output is the
    path of the agent's files without suffix.

    Stable-Baselines3 saves with pickle, and a pickle can run any code on the machine that opens it. The
    file is opened only if you state that you trust its author.
    """
    if not trust:
        allowed = "only with --trust, as such files run code of their author's when they are opened"
        raise InvalidValueError("file to export", str(path), allowed)
    environment_id = only("--env", env)
    set_by_id = {"control_frequency": EnvConfig.control_frequency, **find_preset(environment_id).keywords}
    keywords: dict[str, Any] = {
        **set_by_id,
        "scenario": only("--scenario", scenario),
        "action_mode": action_mode,
    }
    if control_frequency is not None:
        keywords["control_frequency"] = control_frequency
    with closing(gymnasium.make(environment_id, **keywords)) as made:
        layout: ObservationLayout = made.get_wrapper_attr("observation_layout")
    model, scale = _open(path, algo, normalizer)
    facts = AgentFacts(environment_id, keywords, layout, _run_of(model, seed))
    policy = export_agent(model, scale, facts)
    with closing(policy.make_env()), FolderLock(output.absolute().parent).hold():  # on which it can act
        tensors, card = save_agent(policy, output)
    terminal = Terminal.of(quiet=False, as_json=as_json)
    terminal.report({"tensors": str(tensors), "card": str(card)}, lines=[f"agent: {tensors} and {card}"])


def _open(path: Path, algorithm: str, normalizer: Path | None) -> tuple[Any, Normalizer]:
    """The model and its normaliser, of files that the user trusts."""
    trained_by = ALGORITHMS.find(algorithm).load_class()
    from prp_gym.agents.sb3.trusted_files import open_trusted_model, open_trusted_normalizer

    model = open_trusted_model(path, trained_by, algorithm)
    if normalizer is not None:
        return model, open_trusted_normalizer(normalizer)
    return model, identity_normalizer(sum(model.observation_space.shape or ()))


def _run_of(model: Any, seed: int | None) -> TrainingRecord:
    """What is known of a training that this package did not do."""
    known = model.seed if seed is None else seed
    if known is None:
        raise InvalidValueError("seed", None, "a whole number, with --seed: the model does not know its own")
    command = shlex.join(["prp-gym", *sys.argv[1:]])
    return TrainingRecord(command, known, model.num_timesteps, 0.0, {}, ())
