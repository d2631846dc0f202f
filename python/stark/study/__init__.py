"""Studies: many runs of a scene with different options, on this machine or a cluster.

    study = stark.study.run("plan.toml", "out/slope")
    study.rows()

``docs/studies.md`` is the guide.
"""

from .folder import RunEntry, StudyError
from .plan import Limits, Plan, PlanError
from .study import Study, resume, run

__all__ = ["Limits", "Plan", "PlanError", "RunEntry", "Study", "StudyError", "resume", "run"]
