"""Scene documents: a scene as a file, to be loaded anywhere.

    scene.save("scene.json", settings={"time_step": 1 / 60}, until=2.0)

    $ stark run scene.json

    scene = stark.load_scene("scene.json")

A document is JSON beside a file of arrays (NPZ). It holds bodies, materials, layers, energies, joints,
actuators, attachments, friction, motions and settings; formulas of users as formulas. Loading executes
nothing. ``docs/scene_documents.md`` has the format, ``schema()`` its JSON Schema."""

from .errors import DocumentError
from .format import FORMAT_VERSION, schema
from .loading import SceneDocument, load_scene, read

__all__ = ["FORMAT_VERSION", "DocumentError", "SceneDocument", "load_scene", "read", "schema"]
