"""`TuningTask`: the controller that is tuned, its budget and its episodes."""

from dataclasses import dataclass

from prp_gym.checks import LARGEST_WHOLE, choice, whole
from prp_gym.errors import InvalidValueError
from prp_gym.tasks.setup import ENGINES, MUJOCO

TRAINING_SEEDS = 1_000_000
"""Number of episode seeds of one seed of the search; those of search k begin at (k + 1) times this."""

VALIDATION_SEED = 500_000_000
"""First seed of the episodes that no search uses."""

EPISODES = 24
"""Training episodes of every candidate, divided evenly among the scenarios."""

FINAL_EPISODES = 100
"""Fresh episodes that compare the best candidates of a search with its start."""

SAMPLING, GRADIENT = "sampling", "gradient"
METHODS = (SAMPLING, GRADIENT)
"""How a search finds candidates: at random around good ones and by Optuna, or along derivatives."""

_SEARCHES = VALIDATION_SEED // TRAINING_SEEDS - 1


@dataclass(frozen=True)
class TuningTask:
    """A controller on an environment, and the search for its settings.

    Attributes:
        environment_id: id of the environment, as `gymnasium.make` takes it.
        controller: name of the controller.
        scenarios: scenarios of the environment, over whose mean scores the mean is taken; each once.
        control_frequency: control frequency of the environment [Hz].
        budget: control steps that may be simulated, of all environments together.
        episodes: number of episodes of every candidate, divided evenly among the scenarios; all candidates
            have the same episodes.
        seed: seed of the search and of its episodes.
        engine: engine of the environment, also in the validation.
        method: how candidates are found: `sampling` or `gradient`.
        final_episodes: number of fresh episodes on which the best candidates are compared with the start,
            divided as `episodes` are.

    Raises:
        UnknownNameError: an engine or a method that does not exist.
        InvalidValueError: a number that is not whole or too small, or too large a seed; no scenario, or one
            twice.
    """

    environment_id: str
    controller: str
    scenarios: tuple[str, ...]
    control_frequency: float
    budget: int
    episodes: int = EPISODES
    seed: int = 0
    engine: str = MUJOCO
    method: str = SAMPLING
    final_episodes: int = FINAL_EPISODES

    def __post_init__(self) -> None:
        choice("engine", self.engine, ENGINES)
        choice("method", self.method, METHODS)
        if not self.scenarios or len(set(self.scenarios)) < len(self.scenarios):
            raise InvalidValueError("scenarios", self.scenarios, "at least one, each once")
        for name, least, most in (
            ("budget", 1, LARGEST_WHOLE),
            ("episodes", 1, TRAINING_SEEDS - len(self.scenarios)),
            ("seed", 0, _SEARCHES - 1),
            ("final_episodes", 1, TRAINING_SEEDS - len(self.scenarios)),
        ):
            whole(name, getattr(self, name), least, most)

    @property
    def first_seed(self) -> int:
        """Seed of the first training episode."""
        return TRAINING_SEEDS * (self.seed + 1)
