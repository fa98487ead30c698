"""The best policy of a training run as the files of an agent."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import BinaryIO, TypeVar

import numpy as np
import torch

from prp_gym.agents.policy.agent_card import CurvePoint, TrainingRecord
from prp_gym.agents.policy.agent_file import save_agent
from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.agents.training.export import AgentFacts, export_agent
from prp_gym.agents.training.model import Learner, make_learner
from prp_gym.agents.training.recipes import Recipe, make_recipe
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.errors import RunFolderError
from prp_gym.files.archive import check_archive
from prp_gym.files.regular_file import open_regular

ValueT = TypeVar("ValueT")


def write_agent(
    folder: RunFolder, recipe: Recipe, learner: Learner, normalizer: Normalizer, steps: int
) -> None:
    """Write the agent's files into the folder of its run.

    Args:
        folder: folder of the run, with its `run.json` and `curve.json`.
        recipe: recipe of the training.
        learner: model with the agent's weights.
        normalizer: normaliser of the agent's features.
        steps: number of training steps after which the weights were stored.

    Raises:
        RunFolderError: the files of the run cannot be read.
        InvalidValueError: a network that cannot be exported.
        OutputError: the folder cannot be written to.
    """
    facts = AgentFacts(
        recipe.environment_id,
        recipe.env_kwargs,
        learner.env.get_attr("observation_layout", 0)[0],
        _describe(folder, recipe, steps),
    )
    save_agent(export_agent(learner.model, normalizer, facts), folder.agent)


def _describe(folder: RunFolder, recipe: Recipe, steps: int) -> TrainingRecord:
    facts, rows = folder.read_facts(), folder.read_curve().rows
    points = tuple(CurvePoint(row.steps, row.seconds, row.score, row.violations) for row in rows)
    seconds = [point.seconds for point in points if point.steps == steps]
    if not seconds:
        raise RunFolderError(folder.path, f"its learning curve has no evaluation at step {steps}")
    return TrainingRecord(facts.command, facts.seed, steps, seconds[0], recipe.to_plain(), points)


def export_run(path: Path) -> None:
    """Write the agent's files of a finished run that lacks them.

    Args:
        path: path of the run's folder.

    Raises:
        RunFolderError: the folder holds no finished run, or one with a damaged file.
        UnknownNameError: an algorithm, environment or key of the run's `config.yml` that does not exist.
    """
    folder = RunFolder(path.resolve())
    if not folder.is_finished:
        raise RunFolderError(path, "it holds no finished run", "Train it to the end first")
    content = folder.read_config()
    algorithm, environment_id = content.pop("algorithm"), content.pop("environment")
    recipe = make_recipe(algorithm, environment_id, content)
    steps = int(folder.read_result()["best"]["steps"])
    normalizer = _open(folder, folder.path / "best_normalizer.npz", _read_normalizer)
    with closing(make_learner(recipe, 0)) as learner:
        policy = learner.model.policy
        _open(
            folder,
            folder.path / "best.pt",
            lambda file: policy.load_state_dict(torch.load(file, weights_only=True)),
        )
        write_agent(folder, recipe, learner, normalizer, steps)


def _open(folder: RunFolder, path: Path, read: Callable[[BinaryIO], ValueT]) -> ValueT:
    """What a function reads from an archive of arrays.

    Raises:
        RunFolderError: the archive is missing or damaged.
    """
    try:
        with open_regular(path) as file:
            check_archive(path, file)
            return read(file)
    except Exception as error:  # a damaged file can raise any exception
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise RunFolderError(folder.path, f"{path.name!r} cannot be read ({reason})") from error


def _read_normalizer(file: BinaryIO) -> Normalizer:
    with np.load(file, allow_pickle=False) as arrays:
        return Normalizer(arrays["mean"], arrays["variance"], float(arrays["epsilon"]), float(arrays["clip"]))
