"""Pictures as arrays that notebooks show."""

from __future__ import annotations

from typing import Any, Self

import numpy as np

from .png import png_bytes


class Picture(np.ndarray):
    """A picture: an array of shape (height, width, 3) and type uint8, sRGB, which notebooks show."""

    @classmethod
    def of(cls, pixels: Any) -> Self:
        """The same memory as a picture."""
        return np.asarray(pixels).view(cls)

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        """What is computed from pictures are plain arrays and numbers."""
        return array[()] if return_scalar else np.asarray(array)

    def _repr_png_(self) -> bytes | None:
        """None for parts of a picture that are none themselves: a channel, a pixel."""
        is_picture = self.dtype == np.uint8 and self.ndim == 3 and self.shape[2] == 3 and self.size > 0
        return png_bytes(np.asarray(self)) if is_picture else None
