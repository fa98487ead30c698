"""`PolicyControls`: controller or agent, gain set, scenario, and factors on the settings."""

from typing import Any

import numpy as np

from prp_gym.errors import PRPError
from prp_gym.runs.choice import TUNED
from prp_gym.tasks.scenario import SCENARIOS
from prp_gym.tuning.search_space import Parameter
from prp_gym.viewing.policy_catalogue import PolicyCatalogue
from prp_gym.viewing.session import Session
from prp_gym.viewing.viewer import Viewer

_NO_GAINS = "none"
_STEP = 0.01  # of a factor


class PolicyControls:
    """The choice of a policy, and sliders for its settings.

    Args:
        gui: viser's container.
        viewer: loop that runs the session.
        catalogue: policies that may be chosen.
        settings: container of the sliders.

    Attributes:
        choice: list of the controllers and agents.
        gains: list of the gain sets.
        sliders: sliders of the factors, by the names of the session's parameters.
        values: the settings with their units.
    """

    def __init__(self, gui: Any, viewer: Viewer, catalogue: PolicyCatalogue, settings: Any) -> None:
        self._gui, self._viewer, self._catalogue = gui, viewer, catalogue
        session = viewer.session
        with gui.add_folder("Controller and scenario"):
            self.choice = gui.add_dropdown("controller", catalogue.names, initial_value=session.source.name)
            sets = self._sets(session.source.name)
            self.gains = gui.add_dropdown("gain set", sets, initial_value=session.source.gains or sets[0])
            self._scenario = gui.add_dropdown("scenario", SCENARIOS, initial_value=session.scenario)
        self.choice.on_update(lambda _: viewer.wish(self._choose))
        self.gains.on_update(lambda _: viewer.wish(self._choose))
        self._scenario.on_update(lambda _: viewer.wish(self._choose_scenario))
        self._folder = settings
        self.sliders: dict[str, Any] = {}
        self._known: dict[str, float] = {}
        self._inside: list[Any] = []
        self._shown: Any = None
        self.refresh()

    def refresh(self) -> None:
        """Show the session's choice, with the sliders of its policy and the values of its settings."""
        session = self._viewer.session
        _assign(self._scenario, session.scenario)
        if self._shown is not session.source:
            self._rebuild(session)
        for name, factor in session.factors.items():
            if self._known[name] != factor:  # a refused one
                self._known[name] = self.sliders[name].value = factor
        text = _settings_text(session)
        if self.values.content != text:
            self.values.content = text

    def _rebuild(self, session: Session) -> None:
        """Make the sliders of another policy."""
        source = session.source
        self._shown = source
        sets = self._sets(source.name)
        _assign(self.choice, source.name)
        if tuple(self.gains.options) != sets:
            self.gains.options = sets
        _assign(self.gains, source.gains or sets[0])
        for item in self._inside:
            item.remove()
        with self._folder:
            title = self._gui.add_markdown(
                "Factors on the settings of the gain set; 1 leaves them as they are."
            )
            self.sliders = {item.name: self._slider(item) for item in session.parameters}
            self.values = self._gui.add_markdown("")
        self._known = dict.fromkeys(self.sliders, 1.0)
        self._inside = [title, *self.sliders.values(), self.values]

    def _slider(self, parameter: Parameter) -> Any:
        """A slider for one factor; 1 leaves the settings as they are."""
        powers = ", ".join(f"{name} by its power {power:g}" for name, power in parameter.powers.items())
        slider = self._gui.add_slider(
            parameter.name.replace("_", " "),
            min=float(parameter.low),
            max=float(parameter.high),
            step=_STEP,
            initial_value=1.0,
            hint=f"Factor [1] that multiplies {powers}.",
        )
        slider.on_update(lambda event: self._wish_factor(parameter.name, event))
        return slider

    def _wish_factor(self, name: str, event: Any) -> None:
        """Wish the factor to which a user has moved a slider; not one that `refresh` has set."""
        if event.client is not None:
            value = float(event.target.value)
            self._viewer.wish(lambda: self._set(name, value))

    def _set(self, name: str, value: float) -> None:
        session = self._viewer.session
        if name in session.factors:  # it is not, if another policy was chosen in the meantime
            self._known[name] = value
            session.set_factor(name, value)

    def _choose(self) -> None:
        """Take the chosen policy; the page shows the former one again if it is refused."""
        name, gains, source = str(self.choice.value), str(self.gains.value), self._viewer.session.source
        sets = self._catalogue.gain_sets(name)
        if gains not in sets:
            gains = TUNED if TUNED in sets else ""
        if (name, gains) == (source.name, source.gains):
            return
        try:
            self._viewer.session.choose_source(self._catalogue.make(name, gains))
        except PRPError:
            self._shown = None
            raise

    def _choose_scenario(self) -> None:
        if self._scenario.value != self._viewer.session.scenario:
            self._viewer.session.choose_scenario(str(self._scenario.value))

    def _sets(self, name: str) -> tuple[str, ...]:
        return self._catalogue.gain_sets(name) or (_NO_GAINS,)


def _assign(handle: Any, value: Any) -> None:
    if handle.value != value:
        handle.value = value


def _settings_text(session: Session) -> str:
    """The settings with their units, as a list."""
    settings = session.source.settings(session.policy)
    if not settings:
        return "This policy has no settings."
    rows = [
        f"| {name.replace('_', ' ')} | {_numbers(value)} {unit} |" for name, (value, unit) in settings.items()
    ]
    return "\n".join(["| setting | value |", "| --- | --- |", *rows])


def _numbers(value: Any) -> str:
    """A value in few characters; a vector of equal components as one number."""
    if isinstance(value, str) or np.size(value) == 0 or value is None:
        return str(value)
    flat = np.ravel(value)
    if flat.dtype.kind not in "iuf":
        return str(value)
    shown = flat[:1] if np.ptp(flat) == 0.0 else flat
    return ", ".join(f"{number:.4g}" for number in shown)
