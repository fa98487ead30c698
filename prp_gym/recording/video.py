"""`Video`: what is recorded, and how."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import whole, within
from prp_gym.errors import InvalidValueError
from prp_gym.recording.composer import Composer
from prp_gym.recording.side import Side

_SIZES = (64, 4096)  # [pixels]
_RATES = (1, 120)  # [1/s]
_SLOWNESS = (0.01, 1000.0)
_SEPARATOR = "x"


@dataclass(frozen=True)
class Video:
    """Size, rate and slowness of a video.

    Attributes:
        width: Width of an image [pixels].
        height: Height of an image [pixels].
        fps: Frames per second.
        slow: Factor by which the video is slower than the episode.
    """

    width: int
    height: int
    fps: int
    slow: float

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            object.__setattr__(self, name, whole(name, getattr(self, name), *_SIZES, "pixels"))
        object.__setattr__(self, "fps", whole("--fps", self.fps, *_RATES, "1/s"))
        object.__setattr__(self, "slow", within("--slow", self.slow, _SLOWNESS, "1"))

    @classmethod
    def of(cls, size: str, fps: int, slow: float) -> Self:
        """A video by the options of the command line.

        Args:
            size: Width and height as WIDTHxHEIGHT [pixels].
            fps: Frames per second.
            slow: Factor by which the video is slower than the episode.

        Raises:
            InvalidValueError: a size of another form; a number out of bounds.
        """
        width, separator, height = size.partition(_SEPARATOR)
        if not (
            separator and width.isascii() and width.isdecimal() and height.isascii() and height.isdecimal()
        ):
            raise InvalidValueError("--size", size, "WIDTHxHEIGHT, such as 1280x720", "pixels")
        return cls(int(width), int(height), fps, slow)

    def count(self, duration: float) -> int:
        """Number of frames of an episode of a duration [s]; the last one shows its end."""
        return max(1, round(duration * self.slow * self.fps)) + 1

    def frames(
        self, sides: Sequence[Side], composer: Composer, duration: float
    ) -> Iterator[NDArray[np.uint8]]:
        """Run the episodes and compose the frames, one after the other.

        Args:
            sides: Episodes beside each other, just reset.
            composer: Composer of the frames.
            duration: Duration of the video in the time of the episodes [s].
        """
        for number in range(self.count(duration)):
            for side in sides:
                side.advance(min(duration, number / (self.fps * self.slow)))
            yield composer.compose(sides)


def video_name(environment_id: str, names: Sequence[str], scenario: str, seed: int) -> Path:
    """File name of a video that says what it shows.

    Args:
        environment_id: Id of the environment.
        names: Names of the policies.
        scenario: Name of the scenario.
        seed: Random seed of the episode.
    """
    plain = ["".join(c if c.isalnum() or c in "-_." else "-" for c in Path(name).name) for name in names]
    return Path(f"{environment_id}_{'_vs_'.join(plain)}_{scenario}_seed{seed}.mp4")
