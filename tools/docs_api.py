"""Pages of the site with the Python interface: which names stand where. Sphinx's autodoc writes the entries.

Public are the names of python/stark/__init__.pyi and those of its modules: `__all__`, or what a module without
it defines.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
from types import ModuleType
from typing import Any

from repository import ROOT

STUB = ROOT / "python" / "stark" / "__init__.pyi"

#: Names of `stark` by page and heading. Those of formulas and symbolic follow by themselves, see _groups().
GROUPS: dict[str, tuple[str, str]] = {
    "scene": ("Scenes", "Scene Anisotropic"),
    "simulation": ("Simulations", "Simulation Settings StepReport StepProgress Checkpoint"),
    "bodies": (
        "Bodies and layers",
        "Body Cloth Solid Rod RigidBody Layer Skin Fibres ClosestPoints Contacts Imu",
    ),
    "values": (
        "Meshes, materials, rotations",
        "TriangleMesh TetMesh SolidMesh ShellMaterial SolidMaterial RodMaterial Surface rotation "
        "to_quaternion deg __version__",
    ),
    "mechanisms": (
        "Joints, actuators, attachments",
        "Joint Wrench joint hold Actuator actuator Coordinate Memory act Attachment",
    ),
    "errors": (
        "Errors and warnings",
        "Error InvalidArgument InvalidSetting InvalidMesh InitialIntersection TraceError InternalError "
        "StepFailed CheckpointError ReproducerError StarkWarning",
    ),
}
#: Classes that public calls give or take, which have no public name of their own.
RETURNED = (
    "stark._core.Diagnosis",
    "stark._core.State",
)
#: Types in signatures that have no page here.
FOREIGN_TYPES = [
    (r"py:.*", r"(numpy|np|collections|typing|pathlib|os|types|enum)(\..*)?"),
]


def public_modules() -> list[str]:
    """Modules that are public names of stark, "mesh" among them."""
    stark = importlib.import_module("stark")
    return [name for name in _stub_names() if isinstance(getattr(stark, name), ModuleType)]


def public_names(module: str = "stark") -> list[str]:
    """Public names of a module that are no modules, in the order of its text."""
    found = importlib.import_module(module)
    names = _stub_names() if module == "stark" else getattr(found, "__all__", None) or _defined(found)
    return [name for name in names if not isinstance(getattr(found, name), ModuleType)]


def _stub_names() -> list[str]:
    return re.findall(r"\b(\w+) as \1\b", STUB.read_text(encoding="utf-8"))


def _defined(module: ModuleType) -> list[str]:
    """Public classes, functions and annotated constants of a module without __all__."""
    names = []
    for node in ast.parse(inspect.getsource(module)).body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            names.append(node.name)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            names.append(node.target.id)
    return [name for name in names if not name.startswith("_") and name not in ("Floats",)]


def pages() -> dict[str, str]:
    """Text of every page by its name, "api/mesh.rst" among them."""
    shown: set[int] = set()
    texts = {}
    for page, (title, names) in _groups().items():
        texts[f"api/{page}.rst"] = _page(title, "", "stark", names.split(), shown)
    texts["api/returned.rst"] = _returned()
    for name in public_modules():
        module = f"stark.{name}"
        intro = f".. automodule:: {module}\n   :no-members:\n"
        texts[f"api/{name}.rst"] = _page(f"stark.{name}", intro, module, public_names(module), shown)
    groups = "\n   ".join([*_groups(), "returned"])
    modules = "\n   ".join(public_modules())
    texts["api/index.rst"] = (
        f"{_title('Python interface')}Every public name, with its signature, shapes, units and errors. Names "
        "on the pages of the package ``stark`` are used as ``stark.NAME``.\n\n"
        f".. toctree::\n   :caption: The package stark\n   :maxdepth: 1\n\n   {groups}\n\n"
        f".. toctree::\n   :caption: Its modules\n   :maxdepth: 1\n\n   {modules}\n"
    )
    return texts


def _groups() -> dict[str, tuple[str, str]]:
    """GROUPS and the names that formulas are written with. Every public name of stark is in one of them."""
    grouped = {name for _, names in GROUPS.values() for name in names.split()}
    rest = [name for name in public_names() if name not in grouped]
    symbolic = set(public_names("stark.symbolic"))
    formulas = set(public_names("stark.formulas"))
    lost = [name for name in rest if name not in symbolic | formulas]
    lost += sorted(grouped.difference(public_names()))
    if lost:
        raise SystemExit(f"tools/docs_api.py: {', '.join(lost)}: enter new names in GROUPS, take old ones out")
    ours = " ".join(name for name in rest if name in formulas)
    functions = " ".join(name for name in rest if name not in formulas)
    written = {"energies": ("Energies and laws", ours), "functions": ("Functions of formulas", functions)}
    return GROUPS | written


def _page(title: str, intro: str, module: str, names: list[str], shown: set[int]) -> str:
    """A page with an entry for each name; objects that an earlier page shows are linked instead."""
    found = importlib.import_module(module)
    entries, elsewhere = [], []
    for name in names:
        value = getattr(found, name)
        place = _place_in_stark(name, value) if module != "stark" else None
        if place is not None and id(value) in shown:
            elsewhere.append(f":py:obj:`{place}`")
            continue
        shown.add(id(value))
        entries.append(_entry(module, name, value))
    also = f"Also here: {', '.join(elsewhere)}.\n" if elsewhere else ""
    parts = [_title(title), intro, also, f".. py:currentmodule:: {module}\n", *entries]
    return "\n".join(part for part in parts if part)


def _place_in_stark(name: str, value: object) -> str | None:
    stark = importlib.import_module("stark")
    return f"stark.{name}" if name in _stub_names() and getattr(stark, name) is value else None


def _entry(module: str, name: str, value: Any) -> str:
    """The directive of one name."""
    full = f"{module}.{name}"
    if inspect.isclass(value):
        inherited = "" if issubclass(value, BaseException) else "   :inherited-members:\n"
        return f".. autoclass:: {full}\n{inherited}"
    if callable(value) and hasattr(value, "__name__") and not _is_alias(value):
        return f".. autofunction:: {full}\n"
    source = getattr(value, "source", None)
    if source:
        return f".. py:data:: {full}\n   :type: {type(value).__name__}\n\n   {source}\n"
    return f".. autodata:: {full}\n   :no-value:\n"


def _is_alias(value: Any) -> bool:
    return type(value).__module__ in ("typing", "types") and not inspect.isroutine(value)


def _returned() -> str:
    text = "Classes without a public name of their own: values of attributes and results of calls.\n"
    entries = [f".. autoclass:: {name}\n" for name in RETURNED]
    return "\n".join([_title("Objects that calls return"), text, *entries])


def _title(text: str) -> str:
    return f"{text}\n{'=' * len(text)}\n\n"


def connect(app: Any) -> None:
    """Hooks for Sphinx."""
