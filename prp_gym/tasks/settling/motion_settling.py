"""`MotionSettling`: a motion has settled near its goal, near a moving reference or near a target model."""

from dataclasses import dataclass

import numpy as np

from prp_gym.robot.arrays import Array, dot, norm
from prp_gym.tasks.settling.criterion import Fields, SettlingCriterion

_STANDSTILL = 1e-6  # of the largest displacement within a sample; a smaller one is rounding


@dataclass(frozen=True)
class MotionSettling(SettlingCriterion):
    """Tolerances of a motion, as displacements of the tip.

    The deviation is the norm over the components, each divided by what moves the tip by 1 cm: a joint or an
    angle that hardly moves counts no more than it moves the tip.

    Attributes:
        actual: Name of the field of the motion.
        desired: Name of the field from which it must not deviate.
        planned: Name of the field of the planned reference.
        centimetre: Deviation of each component that moves the tip by 1 cm, in the units of the field; later
            components of the field are left out.
        moving: Tolerance for a reference that moves [cm].
        resting: Least tolerance for a reference that rests [cm].
        share: Tolerance for a reference that rests, as a share of the whole move [1].
        before_reversals: Whether the motion also has to settle before the planned reference turns back.
    """

    actual: str
    desired: str
    planned: str
    centimetre: tuple[float, ...]
    moving: float
    resting: float
    share: float = 0.0
    before_reversals: bool = False

    @property
    def requires(self) -> tuple[str, ...]:
        """See `SettlingCriterion.requires`."""
        return tuple(dict.fromkeys((self.actual, self.desired, self.planned)))

    @property
    def definition(self) -> str:
        """See `SettlingCriterion.definition`."""
        scales = ", ".join(f"{value:g}" for value in self.centimetre)
        text = f"`{self.actual}` within {self.moving:g} cm of `{self.desired}`"
        if self.share:
            text += (
                f" while that moves, within {100 * self.share:g} % of the whole move (at least "
                f"{self.resting:g} cm) if it rests"
            )
        if self.before_reversals:
            text += ", also before the planned reference turns back"
        return f"{text}; norm over the components, of which ({scales}) [SI] move the tip by 1 cm each"

    def deviations(self, fields: Fields) -> tuple[Array, ...]:
        """See `SettlingCriterion.deviations`: one group, the whole motion."""
        desired = fields[self.desired][..., : len(self.centimetre)]
        count = desired.shape[-1]
        error = (desired - fields[self.actual][..., :count]) / np.array(self.centimetre[:count])
        return (error / self._tolerance(desired, error[0]),)

    def reversals(self, fields: Fields) -> tuple[int, ...]:
        """See `SettlingCriterion.reversals`: where successive displacements of the reference are opposed."""
        if not self.before_reversals:
            return ()
        steps = np.diff(self.reference(fields) / np.array(self.centimetre), axis=0)
        lengths = norm(steps)
        moves = np.flatnonzero(lengths > _STANDSTILL * lengths.max(initial=0.0))
        opposed = dot(steps[moves[:-1]], steps[moves[1:]]) < 0.0
        return tuple(moves[1:][opposed].tolist())

    def reference(self, fields: Fields) -> Array:
        """See `SettlingCriterion.reference`."""
        return fields[self.planned][..., : len(self.centimetre)]

    def _tolerance(self, desired: Array, first: Array) -> float:
        """The tolerance [cm] for a reference (T, size), from the first error (size) [cm]."""
        if (desired != desired[0]).any():
            return self.moving
        return max(self.resting, self.share * float(np.sqrt((first**2).sum())))
