"""`Task`: the task of N environments, composed of the parts that its declaration names."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import Link
from prp_gym.tasks.fields import Field, ObservationLayout
from prp_gym.tasks.parts import ResetOption, observed_layout
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.spec import TaskSpec

if TYPE_CHECKING:  # with MuJoCo, which declarations do not need
    from prp_gym.drawing.overlay import OverlayItem
    from prp_gym.physics.abstract_simulation import Simulation


class Task:
    """The task of N environments: starts, references and errors; the loop counts time and moves the robots.

    Args:
        spec: Declaration of the task.
        setup: Numbers, scenario, keywords and period.

    Attributes:
        spec: Declaration of the task.
        numbers: Numbers of the task's data file.
        scenario: Conditions of the episodes.
        options: The task's own keywords.
        period: Control period [s].
        ranges: Ranges from which this scenario draws.
        parts: World, start sampler, reference and error function.
        layout: Layout of the observation.
        ground_truth_layout: Layout of the ground truth: the observation's fields, then the unobserved ones.
    """

    def __init__(self, spec: TaskSpec, setup: TaskSetup) -> None:
        self.spec = spec
        self.numbers, self.scenario = setup.numbers, setup.scenario
        self.options, self.period, self.ranges = setup.options, setup.period, setup.ranges
        self.parts = spec.entry.compose(setup)
        self.layout = observed_layout(self.parts.world, self.parts.reference)
        self.ground_truth_layout = ObservationLayout(
            (*self.layout.fields, *self.parts.errors.unobserved_fields)
        )

    @property
    def environment_id(self) -> str:
        """The id of the task in Gymnasium."""
        return self.spec.id

    @property
    def model(self) -> PRPArm | Link:
        """The nominal robot, whatever the plant is."""
        return self.parts.world.model

    @property
    def measured_fields(self) -> tuple[Field, ...]:
        """The observed quantities of the robot, in the order in which the physics measures them."""
        return self.parts.world.measured_fields

    @property
    def reset_options(self) -> Mapping[str, ResetOption]:
        """Values that `reset(options=...)` takes, by name."""
        return self.parts.starts.reset_options

    @property
    def target_impedance(self) -> Mapping[str, Array]:
        """The impedance to be rendered: axes (6) of `inertia`, `damping`, `stiffness`; empty without one."""
        return self.parts.errors.target_impedance

    @property
    def greatest_stiffness(self) -> float:
        """The greatest stiffness of the surfaces that are drawn [N/m]; infinite without surfaces."""
        return self.parts.starts.greatest_stiffness

    def make_physics(self, timestep: float, num_envs: int, num_threads: int) -> "Simulation":
        """See `World.make_physics`."""
        return self.parts.world.make_physics(timestep, num_envs, num_threads)

    def draw(self, rngs: Sequence[np.random.Generator], options: Mapping[str, Array]) -> Any:
        """See `StartSampler.draw`."""
        return self.parts.starts.draw(rngs, options)

    def draw_plants(self, rngs: Sequence[np.random.Generator]) -> Any:
        """See `World.draw_plants`."""
        return self.parts.world.draw_plants(rngs)

    def configure(self, physics: "Simulation", ids: NDArray[np.intp], start: Any, plants: Any) -> None:
        """See `World.configure`."""
        self.parts.world.configure(physics, ids, start, plants)

    def begin(self, ids: NDArray[np.intp], start: Any) -> None:
        """Begin new episodes in some environments (n); the others are left as they are.

        The first call covers every environment.
        """
        self.parts.reference.begin(ids, start)
        self.parts.errors.begin(ids, start)

    def reference(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """See `Reference.sample`; zeros are positive, so that compiled code has the same bits."""
        values: Array = self.parts.reference.sample(time, ids) + 0.0
        return values

    def advance(self, ground_truth: Array) -> None:
        """See `ErrorFunction.advance`."""
        self.parts.errors.advance(ground_truth)

    def complete(self, ground_truth: Array) -> None:
        """See `ErrorFunction.complete`."""
        self.parts.errors.complete(ground_truth)

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """See `ErrorFunction.errors`."""
        return self.parts.errors.errors(ground_truth, torque)

    def overlay(self, index: int, duration: float) -> list["OverlayItem"]:
        """See `Reference.overlay`."""
        return self.parts.reference.overlay(index, duration)
