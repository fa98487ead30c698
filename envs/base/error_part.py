"""`ErrorPart`: the declaration of one part of the observation `errors`."""

from dataclasses import dataclass

from prp_gym.checks import choice
from prp_gym.errors import InvalidValueError
from prp_gym.tasks.fields import Field

CLIPPED, SATURATING = "clipped", "saturating"
_LARGEST = {CLIPPED: 10.0, SATURATING: 1.0}


@dataclass(frozen=True)
class ErrorPart:
    """One part of the observation `errors`: a quantity over its scale z, limited by a curve.

    Attributes:
        name: Name of the part.
        quantity: Name of the quantity.
        unit: Units of the quantity.
        scale: Values of the quantity at z = 1, in these units.
        curve: Curve that limits z: `clipped` to ±10, or `saturating`, z/(1 + |z|).
        description: Meaning of the quantity.

    Raises:
        UnknownNameError: a curve that does not exist.
        InvalidValueError: a scale that is not positive, or other than one for each unit.
    """

    name: str
    quantity: str
    unit: tuple[str, ...]
    scale: tuple[float, ...]
    curve: str
    description: str

    def __post_init__(self) -> None:
        choice(f"curve of part {self.name!r}", self.curve, _LARGEST)
        if len(self.scale) != len(self.unit) or not all(value > 0.0 for value in self.scale):
            allowed = f"{len(self.unit)} numbers above 0"
            raise InvalidValueError(f"scale of part {self.name!r}", self.scale, allowed)

    @property
    def saturates(self) -> bool:
        """Whether the curve is `saturating`."""
        return self.curve == SATURATING

    def field(self) -> Field:
        """The part as a field of an observation, without unit."""
        size = len(self.scale)
        return Field.symmetric(
            self.name, ("1",) * size, "joint", (_LARGEST[self.curve],) * size, self.description
        )
