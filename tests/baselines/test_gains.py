"""Gain sets as data: every set has a source, every number belongs to a controller and an environment."""

import tomllib
from dataclasses import fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from prp_gym import list_envs
from prp_gym.baselines import BASELINES, ControllerData, gain_sets, load_gains
from prp_gym.errors import UnknownNameError
from prp_gym.registry import NOT_IN_THE_REPORT

FILES = {
    Path(str(file)).stem: file for file in files("prp_gym.baselines").iterdir() if file.name.endswith("toml")
}
TABLE: dict[str, dict[str, dict[str, Any]]] = {
    name: tomllib.loads(file.read_text(encoding="utf-8"))["gains"] for name, file in FILES.items()
}
SETS = [(controller, name) for controller, sets in TABLE.items() for name in sets]
PRINTED: dict[tuple[str, str], dict[str, Any]] = {
    ("joint_pd", "report"): {"proportional_gain": 50.0, "derivative_gain": 10.0},
    ("joint_pd", "figures"): {
        "proportional_gain": [50.0, 500.0, 50.0],
        "derivative_gain": [15.0, 150.0, 15.0],
    },
    ("joint_inverse_dynamics", "report"): {"proportional_gain": 50.0, "derivative_gain": 10.0},
    ("joint_inverse_dynamics", "figures"): {"proportional_gain": 50.0, "derivative_gain": 15.0},
    ("joint_inverse_dynamics", "fast"): {"proportional_gain": 500.0, "derivative_gain": 35.0},
    ("operational_pd", "report"): {"proportional_gain": 50.0, "derivative_gain": 10.0},
    ("operational_pd", "figures"): {"proportional_gain": 50.0, "derivative_gain": 15.0},
    ("operational_inverse_dynamics", "report"): {"proportional_gain": 100.0, "derivative_gain": 15.0},
    ("compliance", "report"): {"stiffness": 50.0, "damping": 10.0},
    ("impedance", "report"): {
        "inertia": [1.0, 0.5, 1.0, 1.0, 1.0, 1.0],
        "damping": 10.0,
        "stiffness": 50.0,
    },
    ("impedance", "figures"): {
        "inertia": [0.1, 0.5, 0.3, 1.0, 1.0, 1.0],
        "damping": [10.0, 25.0, 10.0, 10.0, 10.0, 10.0],
        "stiffness": [50.0, 75.0, 50.0, 50.0, 50.0, 50.0],
    },
    ("admittance", "report"): {
        "inertia": [1.0, 1.0, 1.0, 1.0, 1.0, 1.0],
        "damping": [1.0, 10.0, 1.0, 1.0, 1.0, 1.0],
        "stiffness": [1.0, 20.0, 1.0, 1.0, 1.0, 1.0],
        "proportional_gain": 50.0,
        "derivative_gain": 10.0,
    },
    ("force_inner_position", "report"): {
        "force_gain": 10.0,
        "integral_gain": 5.0,
        "inertia": [0.5, 0.5, 0.5, 1.0, 1.0, 1.0],
        "derivative_gain": 100.0,
        "proportional_gain": 50.0,
    },
    ("parallel_force_position", "report"): {
        "force_gain": 15.0,
        "integral_gain": 15.0,
        "inertia": 1.0,
        "derivative_gain": 60.0,
        "proportional_gain": 40.0,
    },
}
LEAST_RATE = {  # [Hz]
    ("joint_pd", "report"): 500.0,
    ("joint_pd", "figures"): 1000.0,
    ("operational_pd", "report"): 500.0,
    ("operational_pd", "figures"): 1000.0,
    ("compliance", "report"): 500.0,
    ("force_inner_position", "report"): 100.0,
    ("parallel_force_position", "report"): 50.0,
}


def own_values(controller: str, name: str) -> dict[str, dict[str, Any]]:
    """The sub-tables of a set, by environment id."""
    return {key: value for key, value in TABLE[controller][name].items() if isinstance(value, dict)}


def test_every_controller_has_a_file_of_its_name_and_every_file_a_controller() -> None:
    assert set(TABLE) == set(BASELINES)


def test_sets_that_are_not_ours_have_the_least_rates_that_are_known() -> None:
    found = {
        (controller, name): TABLE[controller][name].get("minimum_frequency")
        for controller, name in SETS
        if not name.startswith("tuned")
    }
    assert {key: rate for key, rate in found.items() if rate is not None} == LEAST_RATE


@pytest.mark.parametrize("controller", BASELINES)
def test_controller_has_the_report_s_gains_and_tuned_ones(controller: str) -> None:
    assert "tuned" in gain_sets(controller)
    assert "report" in gain_sets(controller) or BASELINES[controller].chapter == NOT_IN_THE_REPORT
    assert gain_sets(controller) == tuple(TABLE[controller])


@pytest.mark.parametrize(("controller", "name"), SETS)
def test_set_names_its_source(controller: str, name: str) -> None:
    for table in (TABLE[controller][name], *own_values(controller, name).values()):
        source = table.get("source", TABLE[controller][name]["source"])
        assert isinstance(source, str)
        assert source.strip()


@pytest.mark.parametrize(("controller", "name"), SETS)
def test_set_gives_only_settings_of_its_controller(controller: str, name: str) -> None:
    known = {field.name for field in fields(BASELINES[controller].settings_class)} | {
        "source",
        "minimum_frequency",
    }
    own = own_values(controller, name)
    assert set(TABLE[controller][name]) - set(own) <= known
    for values in own.values():
        assert set(values) - {"target_factor"} <= known
        assert set(values.get("target_factor", ())) <= set(BASELINES[controller].policy.rendered)


@pytest.mark.parametrize(("controller", "name"), SETS)
def test_sub_tables_belong_to_registered_environments(controller: str, name: str) -> None:
    assert set(own_values(controller, name)) <= set(list_envs())


@pytest.mark.parametrize(("controller", "name"), SETS)
def test_set_makes_settings_with_its_numbers(controller: str, name: str) -> None:
    for environment_id in list_envs():
        values = load_gains(controller, name, environment_id)
        del values["source"]
        values.pop("minimum_frequency", None)
        values.pop("target_factor", None)  # multiplies what a task asks for
        settings = BASELINES[controller].settings_class.from_mapping(controller, values)
        assert values
        for key, value in values.items():
            assert np.array_equal(getattr(settings, key), value), environment_id


@pytest.mark.parametrize(("controller", "name"), PRINTED)
def test_gains_of_the_report_are_its_own(controller: str, name: str) -> None:
    for environment_id in list_envs():
        gains = load_gains(controller, name, environment_id)
        del gains["source"]
        assert gains.pop("minimum_frequency", None) == LEAST_RATE.get((controller, name))
        assert gains == PRINTED[controller, name]


def test_adaptive_gains_of_the_report_are_those_of_the_link() -> None:
    gains = load_gains("adaptive", "report", "PRP-Adaptive-v0")
    assert (gains["reference_gain"], gains["damping_gain"]) == (200.0, 40.0)
    assert gains["adaptation_gain"] == [1 / 5000, 1 / 100, 1 / 25]


def test_an_environment_s_own_values_replace_the_set_s(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(
        """
        [gains.tuned]
        stiffness = 1.0
        damping = 2.0
        source = "common"
        [gains.tuned."PRP-A-v0"]
        stiffness = 3.0
        source = "its own"
        """,
        encoding="utf-8",
    )
    spec = replace(BASELINES["compliance"], data=ControllerData(file))
    own, common = (load_gains(spec, "tuned", environment_id) for environment_id in ("PRP-A-v0", "PRP-B-v0"))
    assert own == {"stiffness": 3.0, "damping": 2.0, "source": "its own"}
    assert common == {"stiffness": 1.0, "damping": 2.0, "source": "common"}


@pytest.mark.parametrize("controller", BASELINES)
def test_unknown_set_gets_the_nearest_name_and_all_valid_ones(controller: str) -> None:
    with pytest.raises(UnknownNameError, match=r"'tunde'\. Did you mean 'tuned'\?") as caught:
        load_gains(controller, "tunde", list_envs()[0])
    assert caught.value.kind == f"gain set of controller {controller!r}"
    assert caught.value.valid == tuple(sorted(TABLE[controller]))


def test_unknown_controller_has_no_sets() -> None:
    with pytest.raises(UnknownNameError, match="unknown baseline 'no_controller'") as caught:
        load_gains("no_controller", "report", list_envs()[0])
    assert caught.value.valid == tuple(sorted(BASELINES))
    with pytest.raises(UnknownNameError, match="unknown baseline 'no_controller'"):
        gain_sets("no_controller")
