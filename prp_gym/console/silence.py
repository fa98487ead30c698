"""`Silence`: the progress of a command that was told to be quiet."""

from collections.abc import Sequence

from prp_gym.console.activity import Activity


class Silence:
    """Tells nothing; see `Progress`."""

    def __enter__(self) -> "Silence":
        return self

    def __exit__(self, *_: object) -> None:
        return

    def begin(self, done: float) -> None:
        """See `Progress.begin`."""

    def advance(self, amount: float) -> None:
        """See `Progress.advance`."""

    def reach(self, done: float) -> None:
        """See `Progress.reach`."""

    def run(self, activities: Sequence[Activity]) -> None:
        """See `Progress.run`."""
