"""The specification with which Gymnasium made environments, completed by the length of their episodes."""

import copy
from typing import Any, overload

from gymnasium.envs.registration import EnvSpec


class EpisodeSpec:
    """Attribute `spec` of environments that end their episodes themselves, without a `TimeLimit`.

    Gymnasium assigns a specification without a number of steps to an environment that it has made. Wrappers
    and learning libraries read the number of steps in an episode there, so this attribute adds it: the
    duration in control periods. It is None for environments that Gymnasium did not make.
    """

    @overload
    def __get__(self, environment: None, owner: type[Any]) -> None: ...
    @overload
    def __get__(self, environment: object, owner: type[Any]) -> EnvSpec | None: ...
    def __get__(self, environment: object | None, owner: type[Any]) -> EnvSpec | None:
        return None if environment is None else vars(environment).get("spec")

    def __set__(self, environment: Any, spec: EnvSpec | None) -> None:
        own = copy.copy(spec)  # the caller's may be the registered one
        if own is not None:
            own.max_episode_steps = environment.config.horizon
            own.kwargs = {name: value for name, value in own.kwargs.items() if name != "max_episode_steps"}
        vars(environment)["spec"] = own
