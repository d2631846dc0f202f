"""Pages of the site with the Python interface: which names stand where. Sphinx's autodoc writes the entries.

Public are the names of python/stark/__init__.pyi and those of its modules: `__all__`, or what a module
without it defines.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import sys
from types import ModuleType
from typing import Any

from repository import ROOT

STUB = ROOT / "python" / "stark" / "__init__.pyi"

#: Names of `stark` by page and heading. Those of formulas, symbolic and bodies that are not here follow by
#: themselves, see _groups().
GROUPS: dict[str, tuple[str, str]] = {
    "scene": ("Scenes", "Scene Anisotropic load_scene"),
    "simulation": ("Simulations", "Simulation Settings StepReport StepProgress Diagnosis State Checkpoint"),
    "bodies": (
        "Bodies and layers",
        "Body Cloth Solid Rod RigidBody Layer Skin Fibres ClosestPoints FreePath Contacts Imu JoinedPoints "
        "joined",
    ),
    "values": (
        "Meshes, materials, rotations",
        "TriangleMesh TetMesh SolidMesh ShellMaterial SolidMaterial RodMaterial Surface rotation "
        "to_quaternion deg __version__",
    ),
    "fitting": ("Fits of laws to curves", "fit Fit"),
    "mechanisms": (
        "Joints, actuators, attachments",
        "Joint Wrench joint hold Actuator actuator Coordinate Memory act Attachment",
    ),
    "errors": (
        "Errors and warnings",
        "Error InvalidArgument InvalidSetting InvalidMesh InitialIntersection TraceError InternalError "
        "StepFailed CheckpointError DocumentError ReproducerError StarkWarning",
    ),
}
#: Classes that public calls give or take, which have no public name of their own.
RETURNED = (
    "stark.handle.BodyHandle",
    "stark.selections.Points",
    "stark.selections.Stencils",
    "stark.selections.FrameHandle",
    "stark.named.NamedList",
    "stark.named.NamedTuple",
    "stark.bodies.friction.FrictionTable",
    "stark.bodies.restitution.RestitutionTable",
    "stark.formulas.parameters.Parameter",
    "stark.formulas.parameters.Declaration",
    "stark.formulas.statistics.FormulaStatistics",
    "stark.symbolic.function.Formula",
    "stark._core.SolidLaw",
    "stark._core.ShellLaw",
    "stark._core.RodLaw",
    "stark.robots.kinematics.Placement",
)
#: Names of types in annotations, and what they stand for.
ALIASES = {
    "Array": "array of numbers",
    "ArrayLike": "number, sequence or array",
    "Binding": "what an argument of a formula stands for: points, stencils, a frame",
    "Floats": "array of 64-bit floating-point numbers",
    "Indices": "array of 32-bit integers",
    "Integers": "array of 32-bit integers",
    "PathLike": "``pathlib.Path`` or another path",
    "Side": "body, frame, name of a body, or None for the world",
    "TimeValue": "number, or function of the time [s]",
    "Vec3Like": "three numbers, a sequence or an array",
}
#: Inside the package: types in the constructors of classes that other calls make, and their own base classes.
INTERNAL = frozenset(
    (
        "stark._core.ActuatorDefinition",
        "stark._core.Formula",
        "stark._core.JointDefinition",
        "stark._core.symbolic.ArrayFunction",
        "stark.formulas.arguments.ClockArgument",
        "stark.formulas.arguments.FrameArgument",
        "stark.formulas.arguments.PointArgument",
        "stark.formulas.binding.BoundEnergy",
        "stark.formulas.kinematics.Inputs",
        "stark.formulas.internal.Internal",
        "stark.formulas.recorded_law.Past",
        "stark.formulas.tracing.Trace",
        "stark.handle.SceneLink",
        "stark.joints.definition.Held",
        "stark.named.Named",
        "stark.named.Part",
        "stark.recording.lock.FolderLock",
        "stark.render.camera.Bounds",
        "stark.robots.drives.DrivenRobot",
        "stark.steps.LastStep",
        "stark.steps.Stepping",
        "stark.symbolic.signature.Argument",
    )
)
#: Types in signatures that other projects document.
FOREIGN_TYPES = [
    (r"py:.*", r"(numpy|np|collections|typing|pathlib|os|types|enum|inspect|gymnasium|Box|NDArray)(\..*)?"),
    # Of what environments inherit from Gymnasium.
    (r"py:.*", r"_np_random(_seed)?|set_np_random_through_seed"),
]


def use_local_package() -> None:
    """Has imports find the package in python/ if its extension is built in place, else the installed one."""
    package = ROOT / "python"
    if any((package / "stark").glob("_core*.so")):
        sys.path.insert(0, str(package))


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
    """GROUPS, other bodies, and the names that formulas are written with. Every public name of stark is in
    one of them."""
    grouped = {name for _, names in GROUPS.values() for name in names.split()}
    rest = [name for name in public_names() if name not in grouped]
    symbolic = set(public_names("stark.symbolic"))
    formulas = set(public_names("stark.formulas"))
    bodies = set(public_names("stark.bodies"))
    lost = [name for name in rest if name not in symbolic | formulas | bodies]
    lost += sorted(grouped.difference(public_names()))
    if lost:
        raise SystemExit(
            f"tools/docs_api.py: {', '.join(lost)}: enter new names in GROUPS, take old ones out"
        )
    title, names = GROUPS["bodies"]
    handles = " ".join([names, *(name for name in rest if name in bodies)])
    ours = " ".join(name for name in rest if name in formulas)
    functions = " ".join(name for name in rest if name not in formulas | bodies)
    return GROUPS | {
        "bodies": (title, handles),
        "energies": ("Energies and laws", ours),
        "functions": ("Functions of formulas", functions),
    }


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
        is_foreign = issubclass(value, BaseException) or any(
            base.__module__ == "numpy" for base in value.__mro__
        )
        inherited = "" if is_foreign else "   :inherited-members:\n"
        return f".. autoclass:: {full}\n{inherited}"
    if _is_alias(value):
        return f".. py:type:: {name}\n\n   {ALIASES.get(name, _plain(value))}\n"
    if callable(value) and hasattr(value, "__name__"):
        # Laws and energies have signatures of their own, unlike those of the functions that they wrap.
        has_own = module == "stark.materials" or "__signature__" in getattr(value, "__dict__", {})
        given = str(inspect.signature(value)).replace("'", "") if has_own else ""
        return f".. autofunction:: {full}{given}\n"
    source = getattr(value, "source", None)
    if source:
        return f".. py:data:: {name}\n   :type: {type(value).__name__}\n\n   {source}\n"
    return f".. autodata:: {full}\n   :no-value:\n"


def _is_alias(value: Any) -> bool:
    """Whether a value is a type made of others, `float | str` among them."""
    return type(value).__module__ in ("typing", "types") and not inspect.isroutine(value)


def _plain(value: Any) -> str:
    return re.sub(r"\b(?:\w+\.)+(\w+)", r"\1", str(value))


def _returned() -> str:
    text = (
        "Classes without a public name of their own: values of attributes, results and arguments of calls.\n"
    )
    entries = [f".. autoclass:: {name}\n" for name in RETURNED]
    return "\n".join([_title("Objects that calls give and take"), text, *entries, _aliases()])


def _aliases() -> str:
    rows = "".join(f"``{name}``\n   {meaning}\n\n" for name, meaning in ALIASES.items())
    return f"Names of types in signatures\n----------------------------\n\n{rows}"


def _title(text: str) -> str:
    return f"{text}\n{'=' * len(text)}\n\n"


#: A page of docs/ as docstrings name it.
_GUIDE = re.compile(r"(?:``)?\bdocs/([a-z_]+)\.md(?:``)?")


def connect(app: Any) -> None:
    """Hooks for Sphinx."""
    app.connect("autodoc-process-docstring", _docstring)
    app.connect("autodoc-process-signature", _signature)
    app.connect("doctree-read", _complete)
    app.connect("doctree-read", _leave_inherited_out, priority=100)  # before Sphinx looks for contents
    app.connect("missing-reference", _reference)


def _docstring(app: Any, what: str, name: str, value: Any, options: Any, lines: list[str]) -> None:
    """Indented programs after a line with a colon are programs, |x| is no substitution, and names of guides
    lead to them."""
    for k, line in enumerate(lines):
        program = lines[k + 2 : k + 3] and not lines[k + 1] and lines[k + 2].startswith("    ")
        if program and line.strip() and not line.startswith("    "):
            lines[k] = line.rstrip(":.") + "::"
        lines[k] = re.sub(r"(?<!`)\|(\w+)\|", r"\\|\1\\|", lines[k])
        lines[k] = _GUIDE.sub(r":doc:`/\1`", lines[k])


def _signature(
    app: Any, what: str, name: str, value: Any, options: Any, arguments: str | None, result: str | None
) -> tuple[str, str | None] | None:
    """Classes whose objects only other calls make show no constructor; defaults of dataclasses are Python."""
    if what != "class" or not arguments:
        return None
    if any(internal.rpartition(".")[2] in arguments for internal in INTERNAL):
        return "", None
    return arguments.replace("<factory>", "..."), result


def _complete(app: Any, tree: Any) -> None:
    """Names of types without their module get the one of their page; arrays are shown without parameters."""
    places = {place.rpartition(".")[2]: place for place in RETURNED}
    for node in [node for node in tree.findall() if getattr(node, "attributes", {}).get("refdomain") == "py"]:
        node["reftarget"] = places.get(node["reftarget"], node["reftarget"])
        if node["reftarget"] == "numpy.ndarray":
            _cut_parameters(node)


def _leave_inherited_out(app: Any, tree: Any) -> None:
    """Inherited members stand on the page, but not in its contents beside it."""
    for node in tree.findall():
        owner = getattr(node, "attributes", {}).get("class")
        if owner and node.get("_toc_name"):
            kind = getattr(importlib.import_module(node["module"]), owner, None)
            member = node["fullname"].rpartition(".")[2]
            if inspect.isclass(kind) and member not in kind.__dict__ and hasattr(kind, member):
                node["_toc_name"] = ""


def _cut_parameters(node: Any) -> None:
    """Takes "[tuple[Any, ...], dtype[float64]]" out, which stands after a name."""
    siblings = node.parent.children
    first = siblings.index(node) + 1
    depth, last = 0, first
    while last < len(siblings):
        depth += {"[": 1, "]": -1}.get(siblings[last].astext(), 0)
        if depth == 0:
            break
        last += 1
    if last > first:
        del siblings[first : last + 1]


def _reference(app: Any, env: Any, node: Any, text: Any) -> Any:
    """Types without a page are no links."""
    target = node.get("reftarget", "")
    return text if node.get("refdomain") == "py" and target in INTERNAL.union(ALIASES) else None
