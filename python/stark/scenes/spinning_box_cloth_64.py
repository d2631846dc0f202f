"""Comparison: a turning box under a cotton cloth of 64 x 64 cells."""

import stark

from ._common import bench_settings, spinning_box, spinning_box_observables, turn_box

until: float = 0.5  # [s]
drive = turn_box
observables = spinning_box_observables


def settings() -> dict[str, object]:
    return bench_settings(contact_distance=0.00125)


def build() -> stark.Scene:
    return spinning_box(cells=64)
