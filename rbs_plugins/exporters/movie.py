"""Movies made of pictures on the disk, one after the other: animated GIF by Pillow, MP4 by imageio-ffmpeg."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput
from rbs_core.files import written_whole

ENDINGS = (".gif", ".mp4")
MOST_FPS = {".gif": 50.0, ".mp4": 1000.0}  # viewers show GIF frames of less than 1/50 s slower
MAPPED, TINTS, GRAYS = 128, 32, 32  # of the 256 colours of a GIF, see `_palette`


def need_encoder(owner: str, path: Path) -> None:
    """Makes sure that such a movie can be written.

    Raises:
        BadInput: if what encodes MP4 is not installed.
    """
    if path.suffix == ".mp4":
        try:
            import imageio_ffmpeg

            imageio_ffmpeg.get_ffmpeg_exe()
        except (ImportError, RuntimeError) as error:
            raise BadInput(
                f"{owner}: an MP4 needs imageio-ffmpeg, which is not there ({error}): python -m pip install "
                f"'rbs[movie]', or write a GIF, path='{path.with_suffix('.gif')}'"
            ) from None


def write_movie(path: Path, pictures: Sequence[Path], fps: float, colors: str) -> None:
    """Writes a movie of pictures of one size, which appears complete or not at all; one picture is held at a time.

    Args:
        path: the .gif or .mp4 file.
        pictures: PNG files in order.
        fps: pictures per second.
        colors: name of the colour map of the pictures.
    """
    with written_whole(path) as partial:
        (_write_gif if path.suffix == ".gif" else _write_mp4)(partial, pictures, fps, colors)


def _write_mp4(path: Path, pictures: Sequence[Path], fps: float, colors: str) -> None:
    import imageio_ffmpeg
    from PIL import Image

    with Image.open(pictures[0]) as first:
        size = first.size
    # the name of the file does not tell ffmpeg the format, as it is another until the movie is complete
    writer = imageio_ffmpeg.write_frames(
        str(path), size, fps=fps, macro_block_size=2, ffmpeg_log_level="error", ffmpeg_timeout=0,
        output_params=["-f", "mp4"],
    )  # fmt: skip
    writer.send(None)
    try:
        for picture in pictures:
            with Image.open(picture) as image:
                writer.send(np.ascontiguousarray(image.convert("RGB")))
    finally:
        writer.close()


def _write_gif(path: Path, pictures: Sequence[Path], fps: float, colors: str) -> None:
    """Writes the frames as Pillow compresses them, one behind the other, for ever repeated.

    Pillow alone would hold all frames until the last. A GIF (CompuServe, 1990) is a head, blocks and a last byte, and a
    GIF of one frame has the block that is wanted.
    """
    from PIL import Image

    palette = _palette(colors)
    pause = round(100 / fps).to_bytes(2, "little")
    with path.open("wb") as file:
        for number, picture in enumerate(pictures):
            with Image.open(picture) as image:
                frame = image.convert("RGB").quantize(palette=palette, dither=Image.Dither.NONE)
            if not number:
                width, height = (side.to_bytes(2, "little") for side in frame.size)
                file.write(b"GIF89a" + width + height + b"\0\0\0")
                file.write(b"\x21\xff\x0bNETSCAPE2.0\x03\x01\0\0\0")
            file.write(b"\x21\xf9\x04\0" + pause + b"\0\0" + _block(frame))
        file.write(b";")


def _block(frame: Any) -> bytes:
    """The block of an image with a table of colours of its own, out of the GIF that Pillow makes of it."""
    buffer = io.BytesIO()
    frame.save(buffer, format="GIF")
    data = buffer.getvalue()
    size = 3 << ((data[10] & 7) + 1)  # of the table of colours of the whole file, which begins at byte 13
    table, place = data[13 : 13 + size], 13 + size
    while data[place] == 0x21:  # extensions: two bytes, and pieces that tell their lengths up to an empty one
        place += 2
        while data[place]:
            place += 1 + data[place]
        place += 1
    head, flags = data[place : place + 9], data[place + 9]
    if flags & 0x80:  # it has one already
        return data[place:-1]
    return head + bytes([0x80 | flags | (data[10] & 7)]) + table + data[place + 10 : -1]


def _palette(colors: str) -> Any:
    """256 colours for all frames: those of the map, a quarter as many in three lighter tints for edges, and grays."""
    import pyvista
    from PIL import Image

    def mapped(count: int) -> NDArray[np.float64]:
        return np.asarray(pyvista.LookupTable(colors, n_values=count).values, np.float64)[:, :3]

    tints = [mapped(TINTS) * share + 255 * (1 - share) for share in (0.75, 0.5, 0.25)]
    grays = np.repeat(np.linspace(0, 255, GRAYS)[:, None], 3, axis=1)
    image = Image.new("P", (1, 1))
    image.putpalette(np.concatenate([mapped(MAPPED), *tints, grays]).round().astype(np.uint8).ravel().tolist())
    return image
