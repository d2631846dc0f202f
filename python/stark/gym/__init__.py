"""Learning: Gymnasium environments around scenes (``pip install 'stark-sim[rl]'``).

    env = stark.gym.DragCloth(render_mode="rgb_array")
    observation, info = env.reset(seed=7)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

``SceneEnv`` makes one of any scene file, scene document or ``Task``; ``vector`` runs several in processes of
their own. ``gymnasium.make("stark/DragCloth-v0")`` finds those that come with Stark once ``stark.gym`` is
imported. ``docs/learning.md`` has the contract."""

try:
    import gymnasium as _gymnasium
except ImportError as error:
    raise ImportError(
        "stark.gym needs the package gymnasium: pip install 'stark-sim[rl]' (the extra 'rl')"
    ) from error

from .drag_cloth import DragCloth
from .env import SceneEnv
from .grasp_ball import GraspBall
from .task import Task, TaskError
from .vectors import vector

for _name in ("DragCloth", "GraspBall"):
    if f"stark/{_name}-v0" not in _gymnasium.registry:
        _gymnasium.register(id=f"stark/{_name}-v0", entry_point=f"stark.gym:{_name}")

__all__ = ["DragCloth", "GraspBall", "SceneEnv", "Task", "TaskError", "vector"]
