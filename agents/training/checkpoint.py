"""Checkpoints of training: written atomically, as plain arrays and numbers that need no unpickling."""

import io
import json
import os
import shutil
import zlib
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch

from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.agents.training.model import Learner
from prp_gym.agents.training.run_records import StoredState
from prp_gym.agents.training.training_state import BestPolicy, TrainingState
from prp_gym.artifacts import require_folder
from prp_gym.errors import CheckpointError, OutputError
from prp_gym.files.archive import check_archive
from prp_gym.files.checksum import seal, unseal
from prp_gym.files.file_reader import RECORD_SIZE, FileReader
from prp_gym.files.regular_file import open_regular
from prp_gym.files.typed_reader import TypedReader

_PREFIX = "checkpoint-"
_STATE, _TENSORS, _ARRAYS, _REPLAY = "state.json", "tensors.pt", "arrays.npz", "replay.npz"
_COUNTERS = ("num_timesteps", "_n_updates", "_episode_num")
_BUFFER = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
_NORMALIZER = ("mean", "variance")


def find_checkpoint(folder: Path) -> list[Path]:
    """A list with the newest checkpoint in a run's folder; an empty list where there is none."""
    return sorted(folder.glob(f"{_PREFIX}*"))[-1:]


def checkpoint_steps(folder: Path) -> int:
    """Number of training steps from which a run in a folder would go on; 0 without a checkpoint."""
    return max((int(path.name.removeprefix(_PREFIX)) for path in find_checkpoint(folder)), default=0)


def write_checkpoint(folder: Path, learner: Learner, state: TrainingState) -> None:
    """Write everything that a resumed training needs, then remove the previous checkpoint.

    Args:
        folder: folder of the run.
        learner: model in training and its environments.
        state: progress of the run.

    Raises:
        OutputError: the folder was removed, or cannot be written to; the previous checkpoint stays.
    """
    require_folder(folder)
    target = folder / f"{_PREFIX}{learner.model.num_timesteps:012d}"
    part = folder / f".{target.name}.part"
    try:
        if not target.exists():
            shutil.rmtree(part, ignore_errors=True)
            part.mkdir()
            _write_parts(part, learner, state)
            os.rename(part, target)
            _sync(folder)
        for old in folder.glob(f"{_PREFIX}*"):
            if old != target:
                shutil.rmtree(old, ignore_errors=True)
    except OSError as error:
        raise OutputError(target, error) from error
    finally:
        shutil.rmtree(part, ignore_errors=True)


def remove_incomplete(folder: Path) -> None:
    """Remove checkpoints that were not written to their end."""
    for path in folder.glob(f".{_PREFIX}*.part"):
        shutil.rmtree(path, ignore_errors=True)


def remove_checkpoints(folder: Path) -> None:
    """Remove all checkpoints of a run, including incomplete ones."""
    remove_incomplete(folder)
    for path in folder.glob(f"{_PREFIX}*"):
        shutil.rmtree(path, ignore_errors=True)


def _write_parts(folder: Path, learner: Learner, state: TrainingState) -> None:
    model: Any = learner.model
    tensors = io.BytesIO()  # torch itself reports a full disk as an error of its own kind
    torch.save(_tensors(model, state), tensors)
    (folder / _TENSORS).write_bytes(tensors.getbuffer())
    arrays = _arrays(learner, state)
    np.savez(folder / _ARRAYS, **arrays)
    if getattr(model, "replay_buffer", None) is not None:
        np.savez(folder / _REPLAY, **_replay(model.replay_buffer))
    checksums = {path.name: _checksum(path) for path in sorted(folder.iterdir())}
    numbers = {
        "counters": {name: getattr(model, name) for name in _COUNTERS},
        "action_space": model.action_space.np_random.bit_generator.state,
        "curve": [asdict(row) for row in state.curve],
        "violations": asdict(state.violations),
        "seconds": state.seconds,
        "evaluation_seconds": state.evaluation_seconds,
        "resumes": state.resumes,
        "best": [{"steps": best.steps, "score": best.score} for best in state.best],
        "checksums": checksums,
    }
    (folder / _STATE).write_text(json.dumps(seal(numbers)) + "\n", encoding="utf-8")
    for path in folder.iterdir():
        _sync(path)
    _sync(folder)


def _sync(path: Path) -> None:
    """Wait until a file or folder is on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _checksum(path: Path) -> int:
    value = 0
    with open_regular(path) as file:
        while block := file.read(1 << 22):
            value = zlib.crc32(block, value)
    return value


def _tensors(model: Any, state: TrainingState) -> dict[str, Any]:
    """Everything that PyTorch stores: parameters, other variables, random state and the best weights."""
    _, names = model._get_torch_save_params()
    return {
        "parameters": model.get_parameters(),
        "variables": {name: getattr(model, name).detach() for name in names},
        "generator": torch.get_rng_state(),
        "best": [dict(best.weights) for best in state.best],
    }


def _arrays(learner: Learner, state: TrainingState) -> dict[str, Any]:
    """Statistics of the normaliser, those of the best policy, and the state of numpy's global generator."""
    arrays: dict[str, Any] = {}
    for name in ("obs_rms", "ret_rms"):
        statistics = getattr(learner.env, name, None)
        if statistics is not None:
            arrays |= {f"{name}.{key}": getattr(statistics, key) for key in ("mean", "var", "count")}
    _, keys, position, has_gauss, cached = np.random.get_state()  # noqa: NPY002 (the algorithms draw from it)
    arrays |= {"generator.keys": keys, "generator.rest": np.array([position, has_gauss, cached])}
    for best in state.best:
        arrays |= {f"best.{name}": getattr(best.normalizer, name) for name in _NORMALIZER}
        arrays["best.scale"] = np.array([best.normalizer.epsilon, best.normalizer.clip])
    return arrays


def _replay(buffer: Any) -> dict[str, Any]:
    """The filled part of a replay buffer."""
    filled = buffer.buffer_size if buffer.full else buffer.pos
    return {name: getattr(buffer, name)[:filled] for name in _BUFFER} | {
        "position": np.array([buffer.pos, int(buffer.full)])
    }


def read_resumes(path: Path) -> int:
    """Number of times that training had been resumed when a checkpoint was written.

    Args:
        path: path of the checkpoint.

    Raises:
        CheckpointError: the checkpoint is damaged.
    """
    return int(_read(path, lambda: _read_numbers(path).resumes))


def restore_checkpoint(path: Path, learner: Learner) -> TrainingState:
    """Restore a learner, and return the progress of its run.

    Args:
        path: path of the checkpoint.
        learner: learner made from the same recipe and seed.

    Raises:
        CheckpointError: the checkpoint is damaged, or belongs to another kind of learner.
    """
    state: TrainingState = _read(path, lambda: _restore(path, learner))
    return state


def _read_numbers(path: Path) -> StoredState:
    """The numbers of a checkpoint, after a check of their checksum and types."""
    file = path / _STATE
    return TypedReader(file).read(StoredState, unseal(file, FileReader(RECORD_SIZE).read_json(file)), "")


def _read(path: Path, read: Callable[[], Any]) -> Any:
    try:
        return read()
    except Exception as error:  # a damaged file can raise any exception
        raise CheckpointError(path, f"{type(error).__name__}: {error}".splitlines()[0]) from error


def _restore(path: Path, learner: Learner) -> TrainingState:
    model: Any = learner.model
    numbers = _read_numbers(path)
    _check_files(path, numbers.checksums)
    with open_regular(path / _TENSORS) as file:
        check_archive(path / _TENSORS, file)
        tensors = torch.load(file, weights_only=True)
    arrays = _load_arrays(path / _ARRAYS)
    model.set_parameters(tensors["parameters"], exact_match=True, device="cpu")
    for name, value in tensors["variables"].items():
        getattr(model, name).data.copy_(value)
    _restore_normalizer(learner, arrays)
    if getattr(model, "replay_buffer", None) is not None:
        _restore_replay(model.replay_buffer, path / _REPLAY)
    for name in _COUNTERS:
        setattr(model, name, numbers.counters[name])
    _restore_generators(model, numbers, tensors, arrays)
    return _training_state(numbers, tensors, arrays)


def _check_files(path: Path, checksums: Mapping[str, int]) -> None:
    """Refuse files other than those that the checkpoint's state names, with their checksums."""
    names = {_TENSORS, _ARRAYS}
    if not names <= set(checksums) <= {*names, _REPLAY}:
        raise ValueError(f"{_STATE} names the files {', '.join(sorted(checksums))}")
    for name, expected in checksums.items():
        if _checksum(path / name) != expected:
            raise ValueError(f"the checksum of {name} does not match")


def _load_arrays(path: Path) -> dict[str, Any]:
    """The arrays of an archive, none of which needs unpickling."""
    with open_regular(path) as file:
        check_archive(path, file)
        with np.load(file, allow_pickle=False) as arrays:
            return dict(arrays)


def _restore_normalizer(learner: Learner, arrays: Mapping[str, Any]) -> None:
    for name in ("obs_rms", "ret_rms"):
        statistics = getattr(learner.env, name, None)
        if statistics is not None:
            statistics.mean, statistics.var = arrays[f"{name}.mean"], arrays[f"{name}.var"]
            statistics.count = float(arrays[f"{name}.count"])


def _restore_replay(buffer: Any, path: Path) -> None:
    with open_regular(path) as file:
        check_archive(path, file)
        with np.load(file, allow_pickle=False) as arrays:
            for name in _BUFFER:  # one by one, since they are large
                values = arrays[name]
                getattr(buffer, name)[: len(values)] = values
            position, full = arrays["position"].tolist()
    if not 0 <= position < buffer.buffer_size:
        raise ValueError(f"{path.name} has position {position} of {buffer.buffer_size}")
    buffer.pos, buffer.full = int(position), bool(full)


def _restore_generators(
    model: Any, numbers: StoredState, tensors: Mapping[str, Any], arrays: Mapping[str, Any]
) -> None:
    torch.set_rng_state(tensors["generator"])
    position, has_gauss, cached = arrays["generator.rest"]
    np.random.set_state(  # noqa: NPY002 (the algorithms draw from it)
        ("MT19937", arrays["generator.keys"], int(position), int(has_gauss), float(cached))
    )
    model.action_space.np_random.bit_generator.state = numbers.action_space


def _training_state(
    numbers: StoredState, tensors: Mapping[str, Any], arrays: Mapping[str, Any]
) -> TrainingState:
    best = []
    for facts, weights in zip(numbers.best, tensors["best"], strict=True):
        epsilon, clip = arrays["best.scale"].tolist()
        normalizer = Normalizer(arrays["best.mean"], arrays["best.variance"], epsilon, clip)
        best.append(BestPolicy(facts.steps, facts.score, weights, normalizer))
    times = numbers.seconds, numbers.evaluation_seconds
    return TrainingState([*numbers.curve], numbers.violations, *times, numbers.resumes, best)
