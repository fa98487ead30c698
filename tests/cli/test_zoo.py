"""The command `prp-gym zoo`."""

import sys
from pathlib import Path

import pytest
import yaml

import prp_gym
from prp_gym.cli.main import main
from tests.cli.test_main import refusal


def test_recipes_of_every_environment_are_written(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(sys, "argv", ["prp-gym", "zoo", str(tmp_path / "ppo.yml")])
    with pytest.raises(SystemExit) as caught:
        main()
    assert caught.value.code == 0
    assert "recipes of ppo" in capsys.readouterr().out
    entries = yaml.safe_load((tmp_path / "ppo.yml").read_text(encoding="utf-8"))
    assert list(entries) == prp_gym.list_envs()


def test_file_that_the_zoo_would_not_read_as_yaml_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    text = refusal(capsys, monkeypatch, "zoo", str(tmp_path / "ppo.py"))
    assert "a name that ends in .yml" in text
