"""Damaged files of a training run: a typed error that names the file, or what was there; never lost."""

import json
import os
import pickle
import shutil
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from prp_gym.agents.training.checkpoint import find_checkpoint, read_resumes
from prp_gym.agents.training.run_export import export_run
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.agents.training.train import is_ready, train
from prp_gym.artifacts import write_json
from prp_gym.errors import CheckpointError, PRPError, RunFolderError
from prp_gym.files.checksum import unseal
from tests.support.damage import damaged
from tests.support.training_runs import interrupted, tiny_job

SHORT = ("n_timesteps=128", "n_epochs=1")


class Touch:
    """Unpickled, it makes a file."""

    def __init__(self, marker: Path) -> None:
        self.marker = marker

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.marker,)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a finished run."""
    folder = tmp_path_factory.mktemp("finished") / "run"
    train(tiny_job(folder, more=SHORT))
    return folder


@pytest.fixture(scope="module")
def begun(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that was interrupted after a checkpoint."""
    folder = tmp_path_factory.mktemp("begun") / "run"
    with pytest.raises(KeyboardInterrupt):
        train(tiny_job(folder), interrupted(2))
    return folder


def error_of(call: Callable[[], Any], *expected: Any) -> str:
    """The message of the typed error of a call; empty where it returns, which is then what is expected."""
    try:
        found = call()
    except PRPError as error:
        return str(error)
    assert not expected or found == expected[0]
    return ""


READ: dict[str, Callable[[RunFolder], Any]] = {
    "run.json": RunFolder.read_facts,
    "curve.json": RunFolder.read_curve,
    "result.json": RunFolder.read_result,
    "config.yml": RunFolder.read_config,
}


@pytest.mark.parametrize("name", READ)
def test_damaged_file_of_a_run_is_refused_or_read_as_it_was(
    tmp_path: Path, finished: Path, name: str
) -> None:
    shutil.copytree(finished, tmp_path / "run")
    folder, read = RunFolder(tmp_path / "run"), READ[name]
    expected, content = read(folder), (finished / name).read_bytes()
    refused = 0
    for damage in damaged(content, 200):
        (folder.path / name).write_bytes(damage)
        told = error_of(lambda: read(folder), expected)
        refused += bool(told)
        assert not told or name in told
        assert (folder.path / name).read_bytes() == damage
    assert refused > 150  # a space more or less, or a byte as it was, changes nothing


@pytest.mark.parametrize("name", READ)
@pytest.mark.parametrize("kind", ["nothing", "folder", "pipe", "empty", "levels", "list"])
def test_file_of_another_kind_is_refused(tmp_path: Path, finished: Path, name: str, kind: str) -> None:
    shutil.copytree(finished, tmp_path / "run")
    path = tmp_path / "run" / name
    path.unlink()
    contents = {"empty": b"", "levels": b"[" * 100_000, "list": b"[1]"}
    if kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind in contents:
        path.write_bytes(contents[kind])
    with pytest.raises(RunFolderError):
        READ[name](RunFolder(tmp_path / "run"))
    assert RunFolder(tmp_path / "run").read_steps() in (0, 128)
    for call in (
        lambda: export_run(tmp_path / "run"),
        lambda: is_ready(tiny_job(tmp_path / "run", more=SHORT)),
    ):
        told = error_of(call)
        assert not told or str(tmp_path / "run") in told


@pytest.mark.parametrize(
    "change",
    [
        lambda result: result.pop("best"),
        lambda result: result.update(best={"steps": "128", "score": 0.5}),
        lambda result: result.update(best=[]),
        lambda result: result.update(seed=None),
        lambda result: result.update(run="os:system"),
    ],
)
def test_result_with_other_keys_or_types_is_refused(
    tmp_path: Path, finished: Path, change: Callable[[dict[str, Any]], Any]
) -> None:
    content = unseal(finished / "result.json", json.loads((finished / "result.json").read_bytes()))
    change(content)
    write_json(tmp_path / "result.json", content)
    with pytest.raises(RunFolderError, match="its result cannot be read"):
        RunFolder(tmp_path).read_result()


def test_run_of_version_0_1_has_no_checksums_and_is_read(tmp_path: Path, finished: Path) -> None:
    shutil.copytree(finished, tmp_path / "run")
    for name in ("run.json", "curve.json", "result.json"):
        path = tmp_path / "run" / name
        content = unseal(path, json.loads(path.read_bytes()))
        content.pop("recipe_sha256", None)
        write_json(path, content)
    (tmp_path / "run" / "agent.json").unlink()
    export_run(tmp_path / "run")
    assert (tmp_path / "run" / "agent.json").read_bytes() == (finished / "agent.json").read_bytes()
    assert is_ready(tiny_job(tmp_path / "run", more=SHORT))


@pytest.mark.parametrize("name", ["best.pt", "best_normalizer.npz"])
def test_damaged_weights_are_refused_and_run_no_code(tmp_path: Path, finished: Path, name: str) -> None:
    shutil.copytree(finished, tmp_path / "run")
    path, marker = tmp_path / "run" / name, tmp_path / "marker"
    content = path.read_bytes()
    payload = pickle.dumps(Touch(marker))
    archive = tmp_path / "archive.zip"
    with zipfile.ZipFile(archive, "w") as file:
        for member in ("archive/data.pkl", "data.pkl", "mean.npy", "archive/version", "variance.npy"):
            file.writestr(member, payload)
    objects = tmp_path / "objects.npz"
    np.savez(objects, mean=np.array([Touch(marker)]), variance=1, epsilon=1, clip=1)
    compressed = tmp_path / "compressed.npz"
    np.savez_compressed(compressed, mean=np.zeros(10), variance=np.ones(10), epsilon=0.0, clip=1.0)
    others = [
        payload,
        archive.read_bytes(),
        objects.read_bytes(),
        compressed.read_bytes(),
        b"",
        content[:-200],
    ]
    for other in others:
        path.write_bytes(other)
        with pytest.raises(RunFolderError, match=f"'{name}' cannot be read"):
            export_run(tmp_path / "run")
    assert not marker.exists()
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(RunFolderError, match="is a named pipe"):
        export_run(tmp_path / "run")


def test_config_with_a_tag_runs_no_code(tmp_path: Path, finished: Path) -> None:
    shutil.copytree(finished, tmp_path / "run")
    marker = tmp_path / "marker"
    config = tmp_path / "run" / "config.yml"
    config.write_text(f"algorithm: !!python/object/apply:pathlib.Path.touch [{marker}]\n", encoding="utf-8")
    with pytest.raises(RunFolderError, match="has the tag"):
        export_run(tmp_path / "run")
    assert not marker.exists()


def test_algorithm_of_a_config_is_a_declared_one(tmp_path: Path, finished: Path) -> None:
    shutil.copytree(finished, tmp_path / "run")
    folder = RunFolder(tmp_path / "run")
    recipe = yaml.safe_load(folder.config.read_text(encoding="utf-8"))
    facts = unseal(folder.run, json.loads(folder.run.read_bytes()))
    for change in ({"algorithm": "os:system"}, {"policy": "os:system"}, {"gamma": "abc"}, {"algorithm": [1]}):
        folder.config.write_text(yaml.safe_dump({**recipe, **change}), encoding="utf-8")
        write_json(folder.run, {**facts, "recipe_sha256": ""})  # as version 0.1 wrote it
        with pytest.raises(PRPError):
            export_run(folder.path)


@pytest.mark.parametrize("name", ["state.json", "arrays.npz", "tensors.pt"])
def test_damaged_checkpoint_is_refused_and_stays(tmp_path: Path, begun: Path, name: str) -> None:
    shutil.copytree(begun, tmp_path / "run")
    there = find_checkpoint(tmp_path / "run")[0]
    path = there / name
    content = path.read_bytes()
    count = 60 if name == "state.json" else 4
    for damage in damaged(content, count):
        path.write_bytes(damage)
        told = error_of(
            (lambda: read_resumes(there))
            if name == "state.json"
            else (lambda: train(tiny_job(tmp_path / "run", existing="resume")))
        )
        assert name in told or (name == "state.json" and json.loads(damage) == json.loads(content))
        assert path.read_bytes() == damage


@pytest.mark.parametrize("name", ["state.json", "arrays.npz", "tensors.pt"])
def test_checkpoint_with_a_pipe_in_it_is_refused(tmp_path: Path, begun: Path, name: str) -> None:
    shutil.copytree(begun, tmp_path / "run")
    path = find_checkpoint(tmp_path / "run")[0] / name
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(CheckpointError, match="is a named pipe"):
        train(replace(tiny_job(tmp_path / "run"), existing="resume"))
