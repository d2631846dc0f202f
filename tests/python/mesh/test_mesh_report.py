"""Reports of meshes count and print."""

from stark.mesh import MeshReport


def test_changes_are_counted_and_printed() -> None:
    report = MeshReport()
    report.add("merged", 3, "3 vertices")
    report.add("merged", 2, "2 vertices")
    report.add("double", 0, "none")
    assert report.count("merged") == 5 and report.count("double") == 0 and len(report.changes) == 2
    assert str(report) == "mesh\n  merged: 3 vertices\n  merged: 2 vertices"
