"""The command `prp-gym export`: foreign files become an agent's, and are opened only if trusted."""

import pickle
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from stable_baselines3.common.vec_env import VecNormalize

import prp_gym
from prp_gym.cli.main import main
from tests.agents.policy.test_agent_file_code import Touch
from tests.agents.training.test_export import SAME
from tests.cli.test_main import refusal
from tests.support.synthetic_agents import ID, KEYWORDS, Trained, observations, trained

OPTIONS = ("--env", ID, "--scenario", "realistic", "--control-frequency", "50")


@pytest.fixture
def files(tmp_path: Path) -> tuple[Trained, Path, Path]:
    """A model, and its files as Stable-Baselines3 writes them."""
    source = trained()
    source.model.save(tmp_path / "model.zip")
    source.wrapper.save(str(tmp_path / "scale.pkl"))
    return source, tmp_path / "model.zip", tmp_path / "scale.pkl"


def export(monkeypatch: pytest.MonkeyPatch, *options: Any) -> None:
    monkeypatch.setattr(sys, "argv", ["prp-gym", "export", *map(str, options)])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 0


def test_trusted_model_becomes_an_agent_that_acts_as_it_does(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    files: tuple[Trained, Path, Path],
) -> None:
    source, model, scale = files
    output = tmp_path / "agent"
    export(monkeypatch, model, *OPTIONS, "--normalizer", scale, "--output", output, "--trust")
    printed = capsys.readouterr().out.replace("\n", "")
    assert f"{output}.safetensors" in printed
    policy = prp_gym.load_agent(output)
    batch = observations(20)
    np.testing.assert_allclose(policy.predict(batch)[0], source.expected(batch)[0], rtol=0, atol=SAME)
    assert policy.environment_keywords == KEYWORDS
    assert policy.card.seed == 7  # the model's own
    assert policy.card.run.command.startswith("prp-gym export")


def test_model_alone_is_taken_as_trained_without_normaliser(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, files: tuple[Trained, Path, Path]
) -> None:
    source, model, _ = files
    stem = model.with_suffix("")  # as Stable-Baselines3 takes it
    export(monkeypatch, stem, *OPTIONS, "--output", tmp_path / "agent", "--trust", "--seed", "4")
    policy = prp_gym.load_agent(tmp_path / "agent")
    batch = observations(20)
    expected = source.model.predict(source.features(batch), deterministic=True)[0]
    np.testing.assert_allclose(policy.predict(batch)[0], expected, rtol=0, atol=SAME)
    assert policy.card.seed == 4


@pytest.mark.parametrize("pickled_file", ["model", "normalizer"])
def test_file_is_opened_only_if_trusted(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    files: tuple[Trained, Path, Path],
    pickled_file: str,
) -> None:
    _, model, scale = files
    marker = tmp_path / "marker"
    scale.write_bytes(pickle.dumps(Touch(marker)))
    options = [
        "export",
        str(model),
        *OPTIONS,
        "--output",
        str(tmp_path / "agent"),
        "--normalizer",
        str(scale),
    ]
    if pickled_file == "model":
        model.write_bytes(scale.read_bytes())
    message = refusal(capsys, monkeypatch, *options)
    assert "only with --trust, as such files run code" in message
    assert not marker.exists()
    refusal(capsys, monkeypatch, *options, "--trust")
    assert marker.exists() == (pickled_file == "normalizer")  # a model that is no zip is not even unpickled
    assert not (tmp_path / "agent.json").exists()


def test_without_trust_the_file_is_not_even_looked_for(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    message = refusal(capsys, monkeypatch, "export", "nowhere.zip", "--env", "no-env", "--output", "x")
    assert "file to export is 'nowhere.zip'; allowed: only with --trust" in message


def not_flat(path: Path, source: Trained) -> None:
    source.wrapper.obs_rms = {"part": source.wrapper.obs_rms}
    source.wrapper.save(str(path))


def without_observations(path: Path, source: Trained) -> None:
    VecNormalize(source.wrapper.venv, norm_obs=False).save(str(path))


@pytest.mark.parametrize(
    ("write", "message"),
    [
        (lambda path, _: path.write_bytes(pickle.dumps([1])), "is not a VecNormalize of observations"),
        (lambda path, _: path.write_bytes(b""), "cannot be read as a VecNormalize"),
        (lambda path, _: path.unlink(), "cannot be opened: No such file"),
        (without_observations, "is not a VecNormalize of observations"),
        (not_flat, "that are not flat arrays"),
    ],
)
def test_file_that_is_no_normaliser_is_refused(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    files: tuple[Trained, Path, Path],
    write: Any,
    message: str,
) -> None:
    source, model, scale = files
    write(scale, source)
    options = ("export", str(model), *OPTIONS, "--output", str(scale.parent / "agent"))
    assert message in refusal(capsys, monkeypatch, *options, "--normalizer", str(scale), "--trust")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--algorithm", "sac"), "cannot be read as a model of sac"),
        (("--algorithm", "pppo"), "unknown algorithm 'pppo'. Did you mean 'ppo'?"),
        (("--env", "PRP-JointTraking-v0"), "unknown environment 'PRP-JointTraking-v0'. Did you mean"),
        (("--env", "PRP-Force-v0"), "observation of the model has shape (33,)"),
        (("--scenario", "report", "--scenario", "realistic"), "allowed: exactly one for this command"),
        (("--control-frequency", "7"), "control_frequency is 7.0 Hz"),
        (("--action-mode", "torqe"), "unknown action_mode 'torqe'"),
    ],
)
def test_wrong_option_is_refused(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    files: tuple[Trained, Path, Path],
    options: tuple[str, ...],
    message: str,
) -> None:
    _, model, _ = files
    common = OPTIONS[2:] if "--env" in options else OPTIONS  # which begin with the environment
    given = ("export", str(model), *common, "--output", str(model.parent / "agent"), "--trust", *options)
    assert message in refusal(capsys, monkeypatch, *given)
    assert not (model.parent / "agent.json").exists()


def test_seed_must_be_known(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], files: tuple[Trained, Path, Path]
) -> None:
    source, model, _ = files
    source.model.seed = None
    source.model.save(model)
    options = ("export", str(model), *OPTIONS, "--output", str(model.parent / "agent"), "--trust")
    assert "seed is None; allowed: a whole number, with --seed" in refusal(capsys, monkeypatch, *options)
