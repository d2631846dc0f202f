"""Reports list findings by kind, each once; suspicious inertias are among them."""

from __future__ import annotations

import numpy as np

from stark.robots import Finding, Inertia, Link, Report
from stark.robots.checks import check_inertias


def test_findings_are_listed_by_kind_and_once() -> None:
    report = Report("'arm.urdf'")
    report.add("dropped", "joint 'a'", "limit of velocity")
    report.add("kept", "joint 'a'", "limits")
    report.add("kept", "joint 'a'", "limits")
    assert report.kept == (Finding("kept", "joint 'a'", "limits"),) and len(report.dropped) == 1
    other = report.copy()
    other.add("suspicious", "x", "y")
    assert not report.suspicious and other.suspicious and not report.assumed
    lines = ["robot from 'arm.urdf'", "  kept (1):", "    joint 'a': limits"]
    assert str(report).splitlines()[:3] == lines


def test_inertias_that_are_hardly_meant_are_suspicious() -> None:
    one = Inertia(1.0, np.zeros(3), 0.1 * np.eye(3))
    links = [Link(name, one) for name in "abc"]
    links += [
        Link("heavy", Inertia(1.0, np.zeros(3), 9.0 * np.eye(3))),
        Link("flat", Inertia(1.0, np.zeros(3), np.diag([0.1, 0.1, 0.5]))),
        Link("none", Inertia(0.0, np.zeros(3), np.zeros((3, 3)))),
        Link("tool"),
    ]
    report = Report("x")
    check_inertias(links, report)
    assert [str(finding) for finding in report.suspicious] == [
        "link 'heavy': mass 1 kg with moments (9, 9, 9) kg m^2: radii of gyration from 3 to 3 m",
        "link 'flat': principal moments (0.1, 0.1, 0.5) kg m^2: none may exceed the sum of the other two "
        "(the triangle inequality)",
        "links: a, b, c have the same inertia: a placeholder?",
    ]
    assert [finding.part for finding in report.assumed] == ["link 'none'", "link 'tool'"]
