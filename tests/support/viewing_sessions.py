"""Sessions of controllers, as `prp-gym view` makes them."""

from prp_gym.runs.choice import GainsChoice
from prp_gym.runs.selection import Selection
from prp_gym.viewing.controller_source import ControllerSource
from prp_gym.viewing.session import Session

SEED = 3


def controller_source(
    environment_id: str, controller: str, gains: str = "tuned", frequency: float = 500.0
) -> ControllerSource:
    """The source of a controller with a gain set."""
    selected = Selection.of([environment_id], ["report"], [controller], GainsChoice.read(gains))
    return ControllerSource(selected.controllers, selected.choices[0], environment_id, frequency)


def controller_session(
    environment_id: str,
    controller: str,
    gains: str = "tuned",
    scenario: str = "randomized",
    frequency: float = 500.0,
) -> Session:
    """A session of a controller."""
    return Session(controller_source(environment_id, controller, gains, frequency), scenario, SEED)
