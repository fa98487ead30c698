"""All classes of cases."""

from bench.fuzz.commands import COMMANDS
from bench.fuzz.environments import ENVIRONMENTS
from bench.fuzz.files import FILES
from bench.fuzz.policies import POLICIES
from bench.fuzz.robot import ROBOT

TARGETS = (*ENVIRONMENTS, *POLICIES, *ROBOT, *FILES, *COMMANDS)
