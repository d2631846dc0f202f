"""The module stark itself: its names, and what it says of those it does not have."""

from __future__ import annotations

import ast
import importlib
import inspect
import subprocess
import sys
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import stark
from stark import _MODULES, _PLACES
from stark.on_demand import _names_in


def test_dir_has_every_name() -> None:
    names = dir(stark)
    assert names == sorted(set(names))
    assert set(stark.__all__) <= set(names)
    assert {"energy", "joint", "scenes", "recording", "Vec3", "sqrt", "Checkpoint"} <= set(names)
    for name in names:
        assert getattr(stark, name) is not None or name.startswith("__")


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda scene, joint: scene.add_box(), r"Scene\.add_box\(\) missing .* 'size'"),
        (lambda scene, joint: scene.add_cloth(), r"Scene\.add_cloth\(\) missing .* 'mesh'"),
        (lambda scene, joint: joint.add_motor(cap=1.0), r"Joint\.add_motor\(\) missing .* 'delta'"),
        (lambda scene, joint: stark.Simulation(scene).run(untl=1.0), r"Simulation\.run\(\) got .* 'untl'"),
    ],
)
def test_errors_on_arguments_name_what_users_called(call: Any, named: str) -> None:
    scene = stark.Scene()
    joint = scene.add_hinge(None, scene.add_box(0.1, mass=1.0), anchor=(0, 0, 0), axis="z")
    with pytest.raises(TypeError, match=f"^{named}"):
        call(scene, joint)


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("Simulator", "Simulation"),
        ("CLOTH", "Cloth"),
        ("enrgy", "energy"),
        ("material_", "material"),
        ("checkpoints", "checkpoint"),
        ("Vec5", "Vec"),
        ("det", "determinant"),
        ("inv", "inverse"),
        ("tr", "trace"),
        ("eye", "identity"),
    ],
)
def test_an_unknown_name_is_answered_with_the_nearest(wrong: str, right: str) -> None:
    with pytest.raises(AttributeError, match=rf"no attribute '{wrong}'; did you mean stark\.{right}"):
        getattr(stark, wrong)


@pytest.mark.parametrize("place", ["recording.Recorder", "mesh.grid", "materials.cotton", "render.Camera"])
def test_a_name_of_a_module_is_answered_with_its_place(place: str) -> None:
    with pytest.raises(AttributeError, match=rf"did you mean stark\.{place}\?"):
        getattr(stark, place.split(".")[1])


def test_an_unknown_name_imports_no_module_of_the_package() -> None:
    """Nor do names that are found in a module that is not loaded, which all public modules let be found."""
    script = """
import sys, stark
before = set(sys.modules)
for wrong in ("Cloht", "qqqqqqqqq", "Recorder", "Camera"):
    try:
        getattr(stark, wrong)
    except AttributeError as error:
        print(error)
print(sorted(m for m in set(sys.modules) - before if m.startswith(("stark", "numpy"))))
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    *answers, imported = run.stdout.splitlines()
    assert imported == "[]"
    assert [answer.partition("; did you mean ")[2] for answer in answers] == [
        *("stark.Cloth?", "", "stark.recording.Recorder?", "stark.render.Camera?")
    ]


@pytest.mark.parametrize("module", _MODULES)
def test_names_of_modules_are_read_as_they_are(module: str) -> None:
    owner = importlib.import_module(f"stark.{module}")
    names = _names_in(inspect.getsource(owner))
    own = {n for n, v in vars(owner).items() if getattr(v, "__module__", "") == owner.__name__}
    assert names == set(owner.__all__) if hasattr(owner, "__all__") else names >= own


def test_python_adds_no_hint_of_its_own() -> None:
    """Tracebacks ended with "did you mean 'cotton'?. Did you mean: 'cotton'?"."""
    for owner, wrong in ((stark, "Simulator"), (stark.materials, "coton"), (stark.Scene(), "ad_cloth")):
        with pytest.raises(AttributeError) as caught:
            getattr(owner, wrong)
        assert "".join(traceback.format_exception(caught.value)).lower().count("did you mean") == 1


@pytest.mark.parametrize("name", ["qqqqqqqqq", "__wrapped__", "_hidden"])
def test_no_guess_where_nothing_is_near(name: str) -> None:
    with pytest.raises(AttributeError) as caught:
        getattr(stark, name)
    assert str(caught.value) == f"module 'stark' has no attribute {name!r}"


def test_the_stub_has_the_names_of_the_module() -> None:
    """Type checkers see what users see: every public name, and no other."""
    stub = ast.parse(Path(stark.__file__).with_name("__init__.pyi").read_text())
    imported = {
        alias.asname for node in ast.walk(stub) if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    not_public = {"array_file", "attributes", "bodies", "errors", "files", "handle", "on_demand"}
    demanded = {*_MODULES, *(name for names in _PLACES.values() for name in names.split())}
    assert imported == {*stark.__all__, *demanded}
    assert not imported & not_public


def test_what_is_loaded_on_demand_is_the_module_itself() -> None:
    assert stark.joints is importlib.import_module("stark.joints")
    with pytest.raises(ImportError):
        exec("from stark import simulator")


def test_importing_is_light() -> None:
    script = (
        "import sys, stark; print(sorted({m.partition('.')[0] for m in sys.modules} & "
        "{'scipy', 'trimesh', 'meshio', 'pytetwild', 'imageio', 'viser', 'matplotlib'}))"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def _members(owner: object, name: str) -> Iterator[tuple[str, object]]:
    """A public object, and the methods and properties that it declares or inherits."""
    yield name, owner
    if inspect.isclass(owner):
        for member in dir(owner):
            value = inspect.getattr_static(owner, member)
            if not member.startswith("_") and (isinstance(value, property) or inspect.isfunction(value)):
                yield f"{name}.{member}", value


def test_every_public_name_says_what_it_is() -> None:
    """Modules and their names, with all methods and properties, have docstrings."""
    missing = set()
    for module in ("", *_MODULES, "materials", "mesh", "surfaces"):
        owner = getattr(stark, module) if module else stark
        for name in getattr(owner, "__all__", dir(owner)):
            value = getattr(owner, name)
            ours = getattr(value, "__module__", None) or ""
            if not name.startswith("_") and ours.startswith("stark") and callable(value):
                named = _members(value, f"{owner.__name__}.{name}")
                missing |= {place for place, member in named if not inspect.getdoc(member)}
    assert not missing


@pytest.mark.parametrize("module", [stark.materials, stark.motion, stark.curves, stark.surfaces])
def test_completion_offers_what_a_module_defines(module: Any) -> None:
    """Not what it imports, such as np and Any."""
    names = dir(module)
    assert not {"np", "Any", "ArrayLike", "annotations", "InvalidArgument"} & set(names)
    assert not [name for name in names if inspect.ismodule(getattr(module, name))]
    public = {"materials": "cotton mooney_rivlin plate presets", "motion": "Motion linear spline usd_mesh"}
    public |= {"curves": "Curve uniaxial relaxation", "surfaces": "Surface paper relative_pressure"}
    assert set(public[module.__name__.removeprefix("stark.")].split()) <= set(names)
