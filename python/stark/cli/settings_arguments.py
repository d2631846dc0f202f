"""Command-line options that set simulation settings and options of scene files, shared by the verbs that
simulate."""

from __future__ import annotations

import argparse
from typing import Any


def add_setting_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a setting by its dotted name, for example newton.step_tolerance=1e-4; may be repeated",
    )
    parser.add_argument("--threads", type=int, metavar="N", help="threads; 0 uses all cores")


def parse_settings(args: argparse.Namespace) -> dict[str, Any]:
    """The settings of ``--set`` and ``--threads`` by dotted name, each checked by the settings themselves."""
    from .._core import InvalidSetting
    from ..settings import Settings

    settings = Settings()
    values: dict[str, Any] = {}
    for text in args.set:
        name = text.partition("=")[0].strip()
        try:
            settings.set_text(text)
        except InvalidSetting as error:
            if not str(error).startswith("unknown setting"):
                raise
            raise InvalidSetting(f"{error}; options of the scene file are given by --option") from None
        values[name] = settings[name]
    if args.threads is not None:
        values["threads"] = args.threads
    return values


def add_option_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--option", action="append", default=[], metavar="NAME=VALUE", help="an option of the scene file"
    )


def parse_options(args: argparse.Namespace) -> dict[str, str]:
    """The options of ``--option`` by name, as texts; the scene file converts them."""
    from .._core import InvalidArgument

    options: dict[str, str] = {}
    for text in args.option:
        name, equals, value = text.partition("=")
        if not equals:
            raise InvalidArgument(f"--option {text}: must be NAME=VALUE")
        options[name] = value
    return options
