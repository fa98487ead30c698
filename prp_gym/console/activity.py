"""`Activity`: a piece of work that is under way."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Activity:
    """A piece of work that is under way.

    Attributes:
        name: name of the work.
        share: share of the work that is done [1]; NaN if it is not known.
    """

    name: str
    share: float = math.nan

    @property
    def text(self) -> str:
        """The name, with the share that is done if it is known."""
        return self.name if math.isnan(self.share) else f"{self.name} ({100 * self.share:.0f} %)"
