"""Pictures and films without a graphics stack: our own software rasteriser, PNG by zlib, mp4 through an
extra.

picture = stark.render.render(sim)                    # (720, 1280, 3) uint8
stark.render.write_png("now.png", picture)
stark.render.write_video(recording, "run.mp4")        # needs: pip install 'stark-sim[video]'
"""

from .array import Picture
from .camera import Camera, auto_camera, scene_bounds
from .fields import field_values
from .picture import render
from .png import read_png, write_png
from .tensors import tensor_values
from .video import write_video

__all__ = [
    "Camera",
    "Picture",
    "auto_camera",
    "field_values",
    "read_png",
    "render",
    "scene_bounds",
    "tensor_values",
    "write_png",
    "write_video",
]
