"""An episode loop with an inner controller, whose observations are errors and states of order 1."""

from prp_gym.envs.core.error_loop import ErrorLoop
from prp_gym.envs.core.mode_loop import ModeLoop


class ErrorModeLoop(ErrorLoop, ModeLoop):
    """N environments in an action mode whose observations are those of `ErrorObservation`.

    `ErrorLoop` turns what `ModeLoop` returns into errors; the inner controller reads the fields of the task.
    """
