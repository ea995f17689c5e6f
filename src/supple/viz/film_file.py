"""Animation files: GIF, or MP4 if imageio-ffmpeg is installed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen
from tempfile import TemporaryFile

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from supple.errors import ModelError, ResultFileError
from supple.optional_packages import optional_package
from supple.storage.atomic_write import replacing

Array8 = NDArray[np.uint8]
Frames = Callable[[int], Array8]
"""Function of the number of a frame, from 0; returns its pixels (rows, columns, 3)."""

FASTEST = 50.0
"""Largest number of frames per second: browsers slow down GIFs with shorter delays."""
_WHITE = 255
"""Index of white in the palette of a GIF."""


def check_film(path: Path | str, frames_per_second: float) -> None:
    """ModelError for an unknown format or a rate out of range, MissingPackageError for MP4 without ffmpeg."""
    suffix = Path(path).suffix.lower()
    if suffix not in (".gif", ".mp4"):
        raise ModelError(f"cannot animate {path}: animations are GIF or MP4; end the path in .gif or .mp4")
    if not 0.0 < frames_per_second <= FASTEST:
        raise ModelError(
            f"cannot animate at {frames_per_second} frames per second: give more than 0, at most 50"
        )
    if suffix == ".mp4":
        optional_package("imageio_ffmpeg", "an MP4 film", "film")


def played_rate(path: Path | str, frames_per_second: float) -> float:
    """Frames per second at which the file plays; delays of a GIF are whole hundredths of a second."""
    if Path(path).suffix.lower() == ".gif":
        return 100.0 / round(100.0 / frames_per_second)
    return frames_per_second


def write_film(path: Path, frames: Frames, number: int, rate: float) -> None:
    """Write the given number of frames in the format of the path, at a rate from `played_rate`."""
    (_write_gif if path.suffix.lower() == ".gif" else _write_mp4)(path, frames, number, rate)


def _write_mp4(path: Path, frames: Frames, number: int, rate: float) -> None:
    """Write H.264 in the pixel format that all players read, which needs even numbers of rows and columns."""
    ffmpeg = optional_package("imageio_ffmpeg", "an MP4 film", "film").get_ffmpeg_exe()
    rows, columns, _ = _even(frames(0)).shape
    pixels = f"-f rawvideo -pix_fmt rgb24 -s {columns}x{rows} -r {rate:.9g} -i -"
    # The name of a temporary file has no suffix of a format.
    film = "-an -c:v libx264 -pix_fmt yuv420p -crf 18 -movflags +faststart -f mp4"
    with replacing(path) as temporary, TemporaryFile() as said:
        command = [ffmpeg, "-y", "-loglevel", "error", *pixels.split(), *film.split(), str(temporary)]
        process = Popen(command, stdin=PIPE, stdout=DEVNULL, stderr=said)
        with suppress(BrokenPipeError), process:
            assert process.stdin is not None
            for i in range(number):
                process.stdin.write(_even(frames(i)).tobytes())
        if process.returncode:
            said.seek(0)
            words = said.read().decode(errors="replace").strip()
            raise ResultFileError(f"cannot write {path}: ffmpeg ended early: {words}")


def _even(frame: Array8) -> Array8:
    """The frame, with a white row added to an odd number of rows, and a white column to an odd number."""
    rows, columns, _ = frame.shape
    return np.pad(frame, ((0, rows % 2), (0, columns % 2), (0, 0)), constant_values=255)


def _write_gif(path: Path, frames: Frames, number: int, rate: float) -> None:
    sampled = {i: frames(i) for i in np.unique(np.linspace(0, number - 1, 9).astype(int)).tolist()}
    palette = _common_palette(np.concatenate(list(sampled.values())))

    def indexed() -> Iterator[Image.Image]:
        for i in range(1, number):
            yield _indexed(sampled[i] if i in sampled else frames(i), palette)

    with replacing(path) as temporary:
        _indexed(sampled[0], palette).save(
            temporary,
            format="GIF",
            save_all=True,
            append_images=indexed(),
            duration=round(1000.0 / rate),
            loop=0,
            # With True the file is a third smaller, but this takes half of the total time of the animation.
            optimize=False,
        )


def _common_palette(sample: Array8) -> Image.Image:
    """255 colours for frames of the whole animation, so that nothing flickers, and white as the last."""
    palette = Image.fromarray(sample).quantize(_WHITE, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    colours = np.full((256, 3), 255)
    found = np.array(palette.getpalette()).reshape(-1, 3)[:_WHITE]
    colours[: len(found)] = found
    palette.putpalette(colours.reshape(-1).tolist())
    return palette


def _indexed(frame: Array8, palette: Image.Image) -> Image.Image:
    """The frame in colours of the palette; Pillow's approximate search would tint the white page."""
    places = np.array(Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE))
    places[(frame[..., 0] & frame[..., 1] & frame[..., 2]) == 255] = _WHITE
    indexed = Image.fromarray(places)
    indexed.putpalette(palette.getpalette() or [])
    return indexed
