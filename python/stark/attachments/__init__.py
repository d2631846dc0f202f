"""Attachments: points glued to bodies or the world. ``scene.attach(cloth, gripper, distance=1e-3)``."""

from stark.attachments.handle import Attachment

__all__ = ["Attachment"]
