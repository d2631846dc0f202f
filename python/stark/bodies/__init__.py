"""Handles of bodies and their layers, what they follow and what they feel."""

from stark.bodies.body import Body
from stark.bodies.cloth import Cloth
from stark.bodies.layers import Fibres, Layer, Skin
from stark.bodies.rigid import RigidBody
from stark.bodies.rod import Rod
from stark.bodies.solid import Solid

#: By kind of body.
HANDLES: dict[str, type[Body]] = {handle.kind: handle for handle in (Cloth, Solid, RigidBody, Rod)}

__all__ = ["HANDLES", "Body", "Cloth", "Fibres", "Layer", "RigidBody", "Rod", "Skin", "Solid"]
