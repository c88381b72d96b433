"""A plain picture of a product in the middle of the work."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

WIDTH, HEIGHT, MARGIN = 640, 480, 24
BACKGROUND, GONE, THERE, LEGAL, PART = (255, 255, 255), (225, 225, 225), (90, 90, 90), (213, 94, 0), (0, 114, 178)


def picture(
    positions: npt.NDArray[np.float64],
    ends: npt.NDArray[np.int64],
    there: npt.NDArray[np.bool_],
    legal: npt.NDArray[np.bool_],
) -> npt.NDArray[np.uint8]:
    """Draws parts as dots and connections as lines.

    ``positions`` is float64 [parts, 3], ``ends`` int64 [connections, 2], the parts of each; ``there`` and
    ``legal`` are bool [connections]: grey where a connection is there, pale where it is not, orange where it
    may be handled next. The picture is uint8 [480, 640, 3]. Parts stand where their positions are in the
    plane of the two directions in which these differ most, or on a circle where one has none. O(pixels *
    (parts + connections)) in the worst case.
    """
    image = np.full((HEIGHT, WIDTH, 3), BACKGROUND, np.uint8)
    places = _places(positions)
    scale = max(0.3, min(1.0, 40 / max(1, len(places))))
    for kind, colour, width in ((~there & ~legal, GONE, 1.0), (there & ~legal, THERE, 1.5), (legal, LEGAL, 2.5)):
        for first, second in ends[kind]:
            _line(image, places[first], places[second], width * scale, colour)
    for place in places:
        _line(image, place, place, 5 * scale, PART)
    return image


def _places(positions: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Where the parts are in the picture: [parts, 2], x and y in pixels."""
    count = len(positions)
    if count == 0 or np.isnan(positions).any():
        angles = 2 * np.pi * np.arange(count) / max(1, count)
        flat = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    else:
        centred = positions - positions.mean(axis=0)
        axes = np.linalg.svd(centred, full_matrices=False)[2][:2]
        # The sign of a direction is free: its greatest number is above 0, so that a picture is the same everywhere.
        axes = axes * np.sign(axes[np.arange(len(axes)), np.abs(axes).argmax(axis=1)])[:, None]
        flat = np.zeros((count, 2))
        flat[:, : len(axes)] = centred @ axes.T
    size = np.array([WIDTH, HEIGHT]) - 2 * MARGIN
    spread = np.ptp(flat, axis=0) if count else np.zeros(2)
    scale = min((size[i] / spread[i] for i in range(2) if spread[i] > 0), default=1.0)
    middle = (flat.max(axis=0) + flat.min(axis=0)) / 2 if count else np.zeros(2)
    placed: npt.NDArray[np.float64] = (flat - middle) * scale * [1, -1] + np.array([WIDTH, HEIGHT]) / 2
    return placed


def _line(
    image: npt.NDArray[np.uint8],
    a: npt.NDArray[np.float64],
    b: npt.NDArray[np.float64],
    width: float,
    colour: tuple[int, int, int],
) -> None:
    """Draws all pixels within ``width`` of the line from ``a`` to ``b``, the edge smoothed over one pixel."""
    low = np.maximum(np.floor(np.minimum(a, b) - width - 1), 0).astype(int)
    high = np.minimum(np.ceil(np.maximum(a, b) + width + 2), [WIDTH, HEIGHT]).astype(int)
    x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
    along = b - a
    length = float(along @ along)
    t = np.clip(((x - a[0]) * along[0] + (y - a[1]) * along[1]) / length, 0, 1) if length > 0 else 0.0
    distance = np.hypot(x - a[0] - t * along[0], y - a[1] - t * along[1])
    cover = np.clip(width + 0.5 - distance, 0, 1)[:, :, None]
    area = image[low[1] : high[1], low[0] : high[0]]
    area[:] = (area * (1 - cover) + np.array(colour) * cover + 0.5).astype(np.uint8)
