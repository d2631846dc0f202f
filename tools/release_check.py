#!/usr/bin/env python3
"""Checks the files before a release: `tools/release_check.py v0.2.0`, with the tag. The workflow that
builds the wheels runs it on every tag; RELEASING.md has the other steps of a release."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path
from urllib.parse import urlparse

import check_versions
from repository import ROOT, run_check


def check(root: Path, tag: str) -> list[str]:
    """What stands in the way of releasing this tag."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    version, errors = project["version"], check_versions.check(root)
    if tag != f"v{version}":
        errors.append(f"the tag is '{tag}', the version in pyproject.toml {version}: must be v{version}")
    return errors + _changelog(root, version) + _urls(project)


def _changelog(root: Path, version: str) -> list[str]:
    """The version has a section with entries, and none are left under Unreleased."""
    text = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    sections = {
        title.split()[0]: body
        for title, body in re.findall(r"^## (.+)\n((?:(?!^## ).*\n?)*)", text, re.MULTILINE)
    }
    errors = []
    if "- " not in sections.get(version, ""):
        errors.append(f"CHANGELOG.md has no entries for {version}")
    if sections.get("Unreleased", "").strip():
        errors.append(f"CHANGELOG.md has entries under Unreleased: move them to {version}")
    return errors


def _urls(project: dict[str, dict[str, str]]) -> list[str]:
    """Addresses are real ones: no domain under .example, which are for placeholders (RFC 2606)."""
    return [
        f"pyproject.toml: {name} = {url} is a placeholder"
        for name, url in project.get("urls", {}).items()
        if (urlparse(url).hostname or "").endswith(".example")
    ]


if __name__ == "__main__":
    sys.exit(run_check("release", check(ROOT, sys.argv[1] if len(sys.argv) > 1 else "")))
