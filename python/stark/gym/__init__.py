"""Learning: Gymnasium environments around scenes (``pip install 'stark-sim[rl]'``).

    env = stark.gym.DragCloth(render_mode="rgb_array")
    observation, info = env.reset(seed=7)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

``SceneEnv`` makes one of any scene file, scene document or ``Task``; ``vector`` runs several in processes of
their own. ``gymnasium.make("stark/DragCloth-v0")`` finds those that come with Stark once ``stark.gym`` is
imported. ``docs/learning.md`` has the contract."""

from typing import TYPE_CHECKING

from stark.on_demand import attach

if TYPE_CHECKING:
    from .drag_cloth import DragCloth as DragCloth
    from .env import SceneEnv as SceneEnv
    from .grasp_ball import GraspBall as GraspBall
    from .task import Task as Task
    from .task import TaskError as TaskError
    from .vectors import vector as vector
else:
    _get, __dir__ = attach(
        "stark.gym",
        {
            "stark.gym.drag_cloth": "DragCloth",
            "stark.gym.env": "SceneEnv",
            "stark.gym.grasp_ball": "GraspBall",
            "stark.gym.task": "Task TaskError",
            "stark.gym.vectors": "vector",
        },
    )

    def __getattr__(name: str) -> object:
        try:
            return _get(name)
        except ModuleNotFoundError as error:
            if str(error.name).partition(".")[0] != "gymnasium":
                raise
            raise ImportError(
                f"stark.gym.{name} needs gymnasium, of the extra 'rl': pip install 'stark-sim[rl]'"
            ) from error


def _register() -> None:
    """Makes the environments known to ``gymnasium.make``, where that is installed."""
    try:
        import gymnasium
    except ImportError:
        return
    for name in ("DragCloth", "GraspBall"):
        if f"stark/{name}-v0" not in gymnasium.registry:
            gymnasium.register(id=f"stark/{name}-v0", entry_point=f"stark.gym:{name}")


_register()

__all__ = ["DragCloth", "GraspBall", "SceneEnv", "Task", "TaskError", "vector"]
