"""Scene files: the packaged ones by name, the user's by path, and the loop that runs them.

A scene file is a Python file with a function ``build()``; ``docs/scene_files.md`` is the contract.
"""

from .options import SceneFileError
from .resuming import resume
from .runner import CHECKPOINT_PERIOD, RunResult, run
from .scene_file import SceneFile, load, names

__all__ = ["CHECKPOINT_PERIOD", "RunResult", "SceneFile", "SceneFileError", "load", "names", "resume", "run"]
