"""The floors of the Python package: a file imports from its own floor or from lower ones, and no file imports
itself by way of others. Imports inside functions and for types count."""

from __future__ import annotations

from pathlib import Path

from python_imports import circles, imports_of_package

PACKAGE = "python/stark"

#: From the ground up; names of modules or packages below stark, the longest that fits a module counts.
FLOORS: tuple[tuple[str, ...], ...] = (
    (
        "_core",
        "_cpu",
        "_interrupts",
        "errors",
        "on_demand",
        "overloads",
        "attributes",
        "files",
        "arguments",
        "caller",
        "named",
        "readings",
    ),
    ("array_file", "point_cache", "rotations", "body_kinds", "palette", "scene_record", "telemetry"),
    ("mesh", "materials", "surfaces", "motion", "settings", "tubes", "symbolic", "curves"),
    ("handle",),
    ("courses", "selections", "joined_points"),
    ("bodies", "formulas"),
    ("joints", "actuators", "attachments", "loads", "measured"),
    ("robots",),
    (
        "document.errors",
        "document.kinds",
        "document.format",
        "document.format_robot",
        "document.recorded",
        "document.robots",
        "document.describing",
        "document.rebuilding",
        "document.writing",
        "document.files",
    ),
    ("scene",),
    ("document",),
    ("steps",),
    ("checkpoint", "reproducer.errors", "reproducer.formulas", "reproducer.parts", "reproducer.rebuilding"),
    ("recording", "render", "replay", "view", "exports", "pictures"),
    ("reproducer.reduction", "reproducer.writing", "simulation", "calibration"),
    ("reproducer",),
    ("__init__",),
    ("scenes",),
    ("study", "gym"),
    ("cli", "__main__"),
)

#: The checker of recordings imports nothing of the rest, and the rest does not import it.
BESIDE = "verify"
USES_WHAT_IS_BESIDE = ("__init__", "cli")


def check(root: Path) -> list[str]:
    """Arrows that point up, circles, modules without a floor."""
    imports = imports_of_package(root / PACKAGE)
    errors = [f"{PACKAGE}: circle of imports: {', '.join(circle)}" for circle in circles(imports)]
    for module, targets in imports.items():
        if floor_of(module) is None and not _is_beside(module):
            errors.append(f"{PACKAGE}: {module} has no floor in tools/python_floors.py")
        errors += [f"{PACKAGE}: {text}" for target in sorted(targets) if (text := _fault(module, target))]
    return errors


def floor_of(module: str) -> int | None:
    """Number of the floor of a module; None for one that has none."""
    name = _inner(module)
    while name:
        for number, floor in enumerate(FLOORS):
            if name in floor:
                return number
        name = name.rpartition(".")[0]
    return None


def _fault(module: str, target: str) -> str:
    """What is wrong with an arrow, or ''."""
    if _is_beside(module) or _is_beside(target):
        allowed = _is_beside(module) and _is_beside(target)
        allowed |= _inner(module).partition(".")[0] in USES_WHAT_IS_BESIDE
        return "" if allowed else f"{module} may not see {target}: stark.{BESIDE} stands beside the rest"
    mine, other = floor_of(module), floor_of(target)
    if mine is None or other is None or other <= mine:
        return ""
    return f"{module} (floor {mine}) may not see {target} (floor {other})"


def _inner(module: str) -> str:
    """Without the name of the package, which is its __init__."""
    return module.partition(".")[2] or "__init__"


def _is_beside(module: str) -> bool:
    return _inner(module).split(".")[0] == BESIDE
