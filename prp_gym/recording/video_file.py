"""Writing of videos: mp4, gif, or a folder of frames, complete or not at all."""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, OutputError
from prp_gym.extras import check
from prp_gym.processes.leftovers import part_of, remove

Frames = Iterator[NDArray[np.uint8]]
"""Frames (height, width, 3) of one size."""

_FORMATS = (".mp4", ".gif", "")
_HUNDREDTHS = 100  # of a second: the unit of a gif's delays
_COLORS = 128  # of a gif


def check_output(path: Path, width: int, height: int, fps: int) -> None:
    """Refuse what cannot be written, before the work begins.

    Args:
        path: Path of the video: `.mp4`, `.gif`, or a folder.
        width: Width of the frames [pixels].
        height: Height of the frames [pixels].
        fps: Frames per second.

    Raises:
        InvalidValueError: another format; for an mp4 an odd size, for a gif a rate that is no divisor of 100.
        MissingPackageError: a package that the format needs is not installed.
        OutputError: the path exists already.
    """
    suffix = path.suffix.lower()
    if suffix not in _FORMATS:
        raise InvalidValueError("--output", str(path), "a name that ends in .mp4 or .gif, or a folder's name")
    if suffix == ".mp4" and (width % 2 or height % 2):
        raise InvalidValueError("size of an mp4", f"{width}x{height}", "even numbers", "pixels")
    if suffix == ".gif" and _HUNDREDTHS % fps:
        raise InvalidValueError("--fps of a gif", fps, "a divisor of 100, such as 20, 25 or 50", "1/s")
    if suffix == ".mp4":
        check("imageio_ffmpeg")
    _refuse_existing(path)


def write_video(path: Path, frames: Frames, size: tuple[int, int], fps: int) -> None:
    """Write a video; a file that is not complete never has its name.

    Args:
        path: Path of the video: `.mp4`, `.gif`, or a folder.
        frames: Frames of the video, in their order.
        size: Width and height of the frames [pixels].
        fps: Frames per second.

    Raises:
        OutputError: the video cannot be written, or its path exists already.
    """
    writers: dict[str, Callable[[Path, Frames, tuple[int, int], int], None]]
    writers = {".mp4": _write_mp4, ".gif": _write_gif, "": _write_folder}
    part = part_of(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        writers[path.suffix.lower()](part, frames, size, fps)
        _refuse_existing(path)
        os.rename(part, path)
    except OSError as error:
        raise OutputError(path, error) from error
    finally:
        with suppress(OSError):
            remove(part)


def _refuse_existing(path: Path) -> None:
    if os.path.lexists(path):
        raise OutputError(path, "it exists already; remove it, or choose another name with --output")


def _write_mp4(path: Path, frames: Frames, size: tuple[int, int], fps: int) -> None:
    import imageio_ffmpeg

    writer = imageio_ffmpeg.write_frames(
        str(path),
        size,
        fps=fps,
        codec="libx264",
        pix_fmt_out="yuv420p",
        macro_block_size=2,
        quality=None,
        output_params=["-crf", "20", "-movflags", "+faststart", "-f", "mp4"],
        ffmpeg_log_level="error",
    )
    writer.send(None)
    try:
        for image in frames:
            writer.send(np.ascontiguousarray(image))
    finally:
        writer.close()


def _write_gif(path: Path, frames: Frames, size: tuple[int, int], fps: int) -> None:
    from PIL import Image

    reduced = (Image.fromarray(image).quantize(_COLORS) for image in frames)
    first = next(reduced)
    delay = 1000 // fps
    first.save(path, format="GIF", save_all=True, append_images=reduced, duration=delay, loop=0, disposal=1)


def _write_folder(path: Path, frames: Frames, size: tuple[int, int], fps: int) -> None:
    from PIL import Image

    if path.exists():
        shutil.rmtree(path)
    path.mkdir()
    for number, image in enumerate(frames):
        Image.fromarray(image).save(path / f"frame_{number:05d}.png")
