"""`LearnedPolicy`: a trained agent with the `predict` method of Stable-Baselines3, computed in numpy."""

from typing import TYPE_CHECKING, Any, ClassVar

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.agents.policy.agent_card import AgentCard, Keyword, make_features
from prp_gym.agents.policy.card_table import card_table, learning_columns
from prp_gym.agents.policy.environment_facts import check_same
from prp_gym.agents.policy.network import Network
from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.checks import flag
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.policy_state import PolicyState, state_to_begin_with
from prp_gym.tables import ResultTable
from prp_gym.tables.data_frame import make_frame
from prp_gym.tasks.setup import MUJOCO

if TYPE_CHECKING:
    from prp_gym.figures.notebook_figure import NotebookFigure
    from prp_gym.tables.data_frame import DataFrame


class LearnedPolicy:
    """A trained agent, which needs neither PyTorch nor Stable-Baselines3.

    Args:
        card: description of the agent.
        normalizer: normaliser of the features.
        network: network that maps normalised features to actions.

    Attributes:
        card: description of the agent.
        normalizer: normaliser of the features.
        network: network that maps normalised features to actions.
        batched: whether `predict` also takes several observations at once; True.
    """

    batched: ClassVar[bool] = True

    def __init__(self, card: AgentCard, normalizer: Normalizer, network: Network) -> None:
        self.card = card
        self.normalizer = normalizer
        self.network = network
        self._layout = card.interface.make_layout()
        self._features = make_features(card.interface)

    def __repr__(self) -> str:
        """The algorithm, the environment and the scores."""
        card = self.card
        scores = ", ".join(f"{score.value:.3f} ({name})" for name, score in card.scores.items())
        return (
            f"<LearnedPolicy {card.algorithm} of training seed {card.seed}, action mode {card.action_mode},"
            f" for {card.environment_id} at {card.control_frequency:g} Hz: score {scores or 'unknown'}>"
        )

    @property
    def table(self) -> ResultTable:
        """What the agent is, in a few lines."""
        return card_table(self.card)

    def _repr_html_(self) -> str:
        """The table for a notebook."""
        return self.table._repr_html_()

    def to_frame(self) -> "DataFrame":
        """The training as a data frame of pandas, a row for each evaluation on held-out episodes.

        Returns:
            steps, wall-clock time, simulated time, score, and violations so far by their kind; units stand
            in `attrs["units"]`.

        Raises:
            MissingPackageError: pandas is not installed.
        """
        columns = learning_columns(self.card)
        units = {"seconds": ("s",), "simulated_seconds": ("s",), "score": ("1",)}
        return make_frame(columns, units)

    def plot(self) -> "NotebookFigure":
        """The learning curve as a figure: score on held-out episodes against simulated time."""
        from prp_gym.figures.learning_figure import draw_learning_curve  # on use: the package stays light

        card = self.card
        columns = learning_columns(card)
        title = f"{card.environment_id}, {card.algorithm}, action mode {card.action_mode}, seed {card.seed}"
        return draw_learning_curve(title, columns["simulated_seconds"], columns["score"])

    @property
    def environment_keywords(self) -> dict[str, Keyword]:
        """Keywords of the environment in which the agent was trained."""
        return dict(self.card.interface.keywords)

    def make_env(self, **overrides: Any) -> gymnasium.Env[Any, Any]:
        """Make the environment in which the agent was trained, simulated by MuJoCo unless said otherwise.

        Args:
            overrides: keywords that replace those of training, such as `scenario` or `render_mode`.

        Raises:
            PRPError: a keyword that does not exist, a value that is not allowed, or an environment in which
                the agent cannot act.
        """
        env: gymnasium.Env[Any, Any] = gymnasium.make(
            self.card.environment_id, **{**self.environment_keywords, "engine": MUJOCO, **overrides}
        )
        try:
            self.check_env(env)
        except InvalidValueError:
            env.close()
            raise
        return env

    def check_env(self, env: Any) -> None:
        """Refuse an environment whose interface differs from that of the training.

        Args:
            env: environment or vector environment of this suite, with or without wrappers, also those of
                Stable-Baselines3.

        Raises:
            InvalidValueError: an environment of another suite or id, or with another observation, action
                mode, control frequency or action size.
        """
        check_same(self.card, env)

    def predict(
        self,
        observation: NDArray[Any] | dict[str, NDArray[Any]],
        state: PolicyState = None,
        episode_start: NDArray[Any] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], PolicyState]:
        """The action for one observation or for a batch, with the conventions of Stable-Baselines3.

        Args:
            observation: (size) or (N, size), as the environment returns it, neither normalised nor stacked.
            state: recurrent state that the last call returned; None at first.
            episode_start: (N) whether an episode starts with this observation, which resets the state.
            deterministic: must be True; the exploration noise of training is not exported.

        Returns:
            action (size) or (N, size), within [-1, 1], and the recurrent state for the next call, None for a
            network without recurrence.

        Raises:
            ShapeError: an observation of another size, for instance behind a wrapper that changes it; a state
                of another agent or number of environments; an `episode_start` of another size.
            InvalidValueError: an observation that is a dictionary or holds no numbers or huge ones; a state
                or an `episode_start` of another kind; `deterministic=False`.
            NonFiniteError: NaN or infinity in the observation or the state.
        """
        if isinstance(observation, dict):
            raise InvalidValueError("observation", sorted(observation), "a flat array, not a dictionary")
        if not flag("deterministic", deterministic):
            raise InvalidValueError(
                "deterministic", deterministic, "True: an exported agent does not explore"
            )
        flat = self._layout.checked(observation)
        lead = flat.shape[:-1]
        memory = state_to_begin_with(self.network.initial_memory(lead), state, episode_start, lead)
        action, after = self.network(self.normalizer(self._features(flat)), memory)
        return action, after or None
