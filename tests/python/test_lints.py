"""Every lint must fail on a planted violation and stay silent on clean code; else it guards nothing."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import check_forbidden  # noqa: E402
import check_layers  # noqa: E402
import check_mirror  # noqa: E402
import check_sizes  # noqa: E402
import check_versions  # noqa: E402

LAYERS = "stark_layer(base)\nstark_layer(linalg DEPENDS base)\nstark_layer(solve DEPENDS linalg base)\n"


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A miniature repository with three layers and no violation."""
    (tmp_path / "src/stark/base").mkdir(parents=True)
    (tmp_path / "src/stark/linalg").mkdir()
    (tmp_path / "src/stark/solve").mkdir()
    (tmp_path / "tests/base").mkdir(parents=True)
    (tmp_path / "src/stark/CMakeLists.txt").write_text(LAYERS)
    (tmp_path / "src/stark/base/a.h").write_text("#pragma once\n#include <vector>\n")
    (tmp_path / "src/stark/linalg/b.cpp").write_text("#include <stark/base/a.h>\n")
    return tmp_path


def test_clean_tree_passes(tree: Path) -> None:
    assert check_layers.check(tree) == []
    assert check_forbidden.check(tree) == []
    assert check_sizes.check(tree) == ([], [])


@pytest.mark.parametrize(
    ("file", "include", "words"),
    [
        ("base/a.h", "<stark/linalg/b.h>", "base may not see linalg"),
        ("linalg/b.cpp", "<stark/solve/c.h>", "linalg may not see solve"),
        ("linalg/b.cpp", "<stark/stark.h>", "umbrella"),
        ("linalg/b.cpp", '"a.h"', "in quotes"),
        ("linalg/b.cpp", "<stark/unknown/c.h>", "linalg may not see unknown"),
    ],
)
def test_layers_reports_a_forbidden_include(tree: Path, file: str, include: str, words: str) -> None:
    (tree / "src/stark" / file).write_text(f"#include {include}\n")
    errors = check_layers.check(tree)
    assert len(errors) == 1
    assert words in errors[0]
    assert file in errors[0]


@pytest.mark.parametrize(
    ("file", "include", "forbidden"),
    [
        ("scene/x.h", "model/x.h", True),
        ("scene/x.h", "y.h", True),
        ("model/x.h", "scene/x.h", False),
        ("model/x.h", "model/z.h", False),
        ("y.h", "model/x.h", False),
    ],
)
def test_parts_of_a_layer_do_not_see_those_above_them(
    tree: Path, file: str, include: str, forbidden: bool
) -> None:
    listed = LAYERS + "stark_layer(sim PARTS scene model DEPENDS base)\n"
    (tree / "src/stark/CMakeLists.txt").write_text(listed)
    for folder in ("scene", "model"):
        (tree / "src/stark/sim" / folder).mkdir(parents=True)
    (tree / "src/stark/sim" / file).write_text(f"#include <stark/sim/{include}>\n")
    errors = check_layers.check(tree)
    assert len(errors) == forbidden
    assert not forbidden or f"src/stark/sim/{file} includes stark/sim/{include}" in errors[0]


def test_layers_reports_a_cycle_and_a_stray_folder(tree: Path) -> None:
    (tree / "src/stark/CMakeLists.txt").write_text(LAYERS.replace("(base)", "(base DEPENDS linalg)"))
    assert any("base depends on linalg" in error for error in check_layers.check(tree))
    (tree / "src/stark/CMakeLists.txt").write_text(LAYERS)
    (tree / "src/stark/stray").mkdir()
    (tree / "src/stark/stray/x.h").write_text("\n")
    assert any("'stray' is not a layer" in error for error in check_layers.check(tree))


@pytest.mark.parametrize(
    "line",
    [
        "std::exit(1);",
        "  exit(2);",
        "abort();",
        "std::abort();",
        'std::cout << "x";',
        'std::cerr << "x";',
        'printf("x");',
        'std::fprintf(stderr, "x");',
        "assert(x > 0);",
        'std::ofstream file("x");',
        'FILE* f = fopen("x", "w");',
        "using namespace std;",
        "#pragma omp parallel for",
    ],
)
def test_forbidden_reports_the_line(tree: Path, line: str) -> None:
    (tree / "src/stark/base/bad.cpp").write_text(f"// first\nvoid f();\n{line}\n")
    errors = check_forbidden.check(tree)
    assert len(errors) == 1
    assert errors[0].startswith("src/stark/base/bad.cpp:3:")


@pytest.mark.parametrize(
    "line",
    [
        "// std::exit(1) is never called",
        "/* abort(); */",
        'throw Error("call exit(1) or printf() yourself");',
        "static_assert(sizeof(int) == 4);",
        "const int n = 1'000'000; const char c = 'x';",
        "std::snprintf(buffer, size, format);",
        "program.exit_block(3);",
    ],
)
def test_forbidden_ignores_comments_strings_and_lookalikes(tree: Path, line: str) -> None:
    (tree / "src/stark/base/good.cpp").write_text(line + "\n")
    assert check_forbidden.check(tree) == []


def test_forbidden_reports_unresolved_notes(tree: Path) -> None:
    (tree / "tests/base/test_a.cpp").write_text("// TO" + "DO: later\n")
    assert len(check_forbidden.check(tree)) == 1


def test_sizes(tree: Path) -> None:
    (tree / "src/stark/base/long.cpp").write_text("\n" * 501)
    (tree / "src/stark/base/edge.cpp").write_text("\n" * 500)
    (tree / "tests/base/test_long.cpp").write_text("\n" * 601)
    (tree / "tests/base/test_edge.cpp").write_text("\n" * 600)
    errors, warnings = check_sizes.check(tree)
    assert len(errors) == 2
    assert "base/long.cpp: 501 lines" in min(errors) and "base/test_long.cpp: 601 lines" in max(errors)
    assert len(warnings) == 2
    assert "base/edge.cpp" in min(warnings) and "base/test_edge.cpp" in max(warnings)


def test_mirror_lists_sources_without_test(tree: Path) -> None:
    (tree / "src/stark/base/tested.cpp").write_text("\n")
    (tree / "tests/base/test_tested.cpp").write_text("\n")
    for folder in ("python/stark/mesh", "python/stark/verify", "tests/python/verify"):
        (tree / folder).mkdir(parents=True)
    for name in ("mesh/shapes.py", "mesh/files.py", "handle.py", "_cpu.py", "verify/files.py", "files.py"):
        (tree / "python/stark" / name).write_text("\n")
    # Two files are called files.py: a test of that name on top is of the one on top.
    for name in ("test_shapes", "test_cpu", "verify/test_verify_files", "test_files"):
        (tree / f"tests/python/{name}.py").write_text("\n")
    orphans = ["src/stark/linalg/b.cpp", "python/stark/handle.py", "python/stark/mesh/files.py"]
    assert check_mirror.orphans(tree) == orphans
    assert [e.split()[0] for e in check_mirror.check(tree)] == orphans
    (tree / "tools").mkdir()
    (tree / "tools/tested_elsewhere.txt").write_text("\n".join([*orphans, "src/stark/base/tested.cpp"]))
    assert check_mirror.check(tree) == [
        "tools/tested_elsewhere.txt: src/stark/base/tested.cpp need not be listed"
    ]


def test_mirror_takes_folders_whose_sources_are_rows_of_a_table(tree: Path) -> None:
    (tree / "tools").mkdir()
    (tree / "tools/tested_elsewhere.txt").write_text("src/stark/linalg/\nsrc/stark/solve/\n")
    (tree / "src/stark/solve/rows").mkdir()
    (tree / "src/stark/solve/rows/c.cpp").write_text("\n")
    assert [e.split(" ")[0:2] for e in check_mirror.check(tree)] == [
        ["src/stark/solve/rows/c.cpp", "has"],  # folders in it are not meant
        ["tools/tested_elsewhere.txt:", "src/stark/solve/"],
    ]


def test_mirror_wants_a_test_for_every_public_module(tree: Path) -> None:
    for folder in ("python/stark/mesh", "tests/python", "tools"):
        (tree / folder).mkdir(parents=True)
    modules = ["mesh/files.py", "mesh/shapes.py", "motion.py", "scene.py"]
    for name in (*modules, "mesh/inner.py"):
        (tree / "python/stark" / name).write_text("\n")
    (tree / "python/stark/__init__.pyi").write_text(
        "from stark import motion as motion\nfrom stark.scene import Scene as Scene\n"
    )
    (tree / "python/stark/mesh/__init__.py").write_text(
        "from .files import load\nfrom stark.mesh.shapes import box\nfrom .inner import helper\n"
        '__all__ = ["box", "load"]\n'
    )
    public = {f"python/stark/{name}" for name in modules}
    assert check_mirror.public_modules(tree) == public
    everything = check_mirror.orphans(tree)
    (tree / "tools/tested_elsewhere.txt").write_text("\n".join(everything))
    # Those that are not public may stay on the list.
    assert {e.split()[0] for e in check_mirror.check(tree)} == public
    assert all(e.endswith("has no test of its name; write one") for e in check_mirror.check(tree))


def test_versions_agree_and_a_difference_is_reported(tmp_path: Path) -> None:
    assert check_versions.check(ROOT) == []
    for name in check_versions.PLACES:
        (tmp_path / name).write_text((ROOT / name).read_text())
    text = (tmp_path / "CITATION.cff").read_text()
    (tmp_path / "CITATION.cff").write_text(text.replace("\nversion: ", "\nversion: 9"))
    assert len(check_versions.check(tmp_path)) == 1


def test_scripts_exit_with_an_error(tree: Path) -> None:
    (tree / "src/stark/base/bad.cpp").write_text(
        "#include <stark/solve/c.h>\nvoid f() { abort(); }\n" + "\n" * 700
    )
    for name in ("layers", "forbidden", "sizes"):
        script = ROOT / "tools" / f"check_{name}.py"
        done = subprocess.run(
            [sys.executable, str(script), str(tree)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 1, done.stdout
        assert "bad.cpp" in done.stdout


def test_mirror_reports_two_tests_of_one_name(tree: Path) -> None:
    for folder in ("robots", "render"):
        (tree / "tests/python" / folder).mkdir(parents=True)
        (tree / "tests/python" / folder / "test_choosing.py").write_text("")
        (tree / "tests/python" / folder / "conftest.py").write_text("")
    errors = [error for error in check_mirror.check(tree) if "another test" in error]
    assert len(errors) == 2
    assert "tests/python/robots/test_choosing.py" in errors[1] + errors[0]
    assert "write test_robots_..." in errors[0] + errors[1]
