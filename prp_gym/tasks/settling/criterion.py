"""`SettlingCriterion`: what has to stay close to its reference, and how close."""

from abc import ABC, abstractmethod
from collections.abc import Mapping

from prp_gym.robot.arrays import Array

Fields = Mapping[str, Array]


class SettlingCriterion(ABC):
    """The tolerances within which the responses of a task count as settled.

    A task declares one in its scoring; the settling time, the unsettled episodes and the limit cycles of its
    tables follow from it.
    """

    @property
    @abstractmethod
    def requires(self) -> tuple[str, ...]:
        """Names of the fields that an episode must have."""

    @property
    @abstractmethod
    def definition(self) -> str:
        """The tolerances in words, with units."""

    @abstractmethod
    def deviations(self, fields: Fields) -> tuple[Array, ...]:
        """Deviations of the responses from their references, in units of their tolerances.

        Args:
            fields: Ground truth by field name, each (T, size).

        Returns:
            Groups of components (T, any size) [1]; a sample is settled where no group has a norm above 1.
        """

    def reversals(self, fields: Fields) -> tuple[int, ...]:
        """Samples at which the planned reference turns back, before which the responses have to settle, too.

        Args:
            fields: Ground truth by field name, each (T, size).

        Returns:
            Indices into the T samples, in their order; none unless the criterion asks for it.
        """
        return ()

    @abstractmethod
    def reference(self, fields: Fields) -> Array:
        """The planned reference (T, size), whose own oscillation is no limit cycle.

        Args:
            fields: Ground truth by field name, each (T, size).
        """
