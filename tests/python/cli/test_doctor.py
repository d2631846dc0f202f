"""``stark doctor``: what it says of this machine."""

from __future__ import annotations

import platform

from _commands import command


def test_doctor(capsys) -> None:
    assert command("doctor") == 0
    out = capsys.readouterr().out
    for word in ("avx2", "linear solvers", "cholesky", "numpy", "ipctk", "trial step: accepted"):
        assert word in out
    assert "linear solvers  automatic" in out
    for package in ("trimesh", "yourdfpy", "usd-core", "gymnasium", "viser", "h5py"):
        assert package in out


def test_only_back_ends_of_this_machine_are_listed(capsys) -> None:
    assert command("doctor", "--no-step") == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("back ends")]
    listed = line.split(maxsplit=2)[2].split(", ")
    assert listed[:2] == ["automatic", "interpreter"] and len(listed) > 2
    assert ("neon" in listed) == (platform.machine() == "aarch64") != ("avx2" in listed)
