"""The controllers and agents among which a viewer chooses."""

import pytest

from prp_gym.agents.policy.agent_file import list_agents
from prp_gym.baselines import gain_sets
from prp_gym.errors import UnknownNameError
from prp_gym.viewing.inner_controller_source import InnerControllerSource
from prp_gym.viewing.policy_catalogue import PolicyCatalogue
from tests.support.viewing_sessions import controller_source

FORCE = "PRP-Force-v0"


@pytest.fixture(scope="module")
def catalogue() -> PolicyCatalogue:
    return PolicyCatalogue(FORCE, 500.0, controller_source(FORCE, "parallel_force_position", "report"))


def test_names_are_those_of_controllers_and_agents(catalogue: PolicyCatalogue) -> None:
    assert catalogue.names[0] == "parallel_force_position"
    assert {"impedance", "force_inner_position", *list_agents(FORCE)} < set(catalogue.names)
    assert len(set(catalogue.names)) == len(catalogue.names)


def test_gain_sets_are_those_of_the_controller(catalogue: PolicyCatalogue) -> None:
    assert catalogue.gain_sets("impedance") == gain_sets("impedance")
    assert catalogue.gain_sets("parallel_force_position") == gain_sets("parallel_force_position")
    assert catalogue.gain_sets(list_agents(FORCE)[0]) == ()


def test_source_has_its_name_and_gains(catalogue: PolicyCatalogue) -> None:
    first = catalogue.make("parallel_force_position", "report")
    other = catalogue.make("parallel_force_position", "tuned")
    assert (first.gains, other.gains, other.name) == ("report", "tuned", "parallel_force_position")
    assert catalogue.make("impedance", "figures").gains == "figures"
    assert catalogue.make(list_agents(FORCE)[0]).parameters(None) == ()  # type: ignore[arg-type]


def test_wrong_names_are_refused(catalogue: PolicyCatalogue) -> None:
    with pytest.raises(UnknownNameError, match="controller or agent"):
        catalogue.make("impedence")
    for name in ("impedance", "parallel_force_position"):
        with pytest.raises(UnknownNameError, match="gain set"):
            catalogue.make(name, "stiff")


def test_inner_controller_stands_among_the_names() -> None:
    source = InnerControllerSource(FORCE, "variable_force_position", 50.0)
    catalogue = PolicyCatalogue(FORCE, 500.0, source)
    assert catalogue.make(source.name, "") is source
    assert catalogue.gain_sets(source.name) == ()
