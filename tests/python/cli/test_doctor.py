"""``stark doctor``: what it says of this machine."""

from __future__ import annotations

from _commands import command


def test_doctor(capsys) -> None:
    assert command("doctor") == 0
    out = capsys.readouterr().out
    for word in ("avx2", "linear solvers", "cholesky", "numpy", "ipctk", "trial step: accepted"):
        assert word in out
    assert "linear solvers  automatic" in out
    for package in ("trimesh", "yourdfpy", "usd-core", "gymnasium", "viser", "h5py"):
        assert package in out
