"""Processors that cannot run the core are refused before it is loaded, with what they lack."""

import os

import pytest

from stark import _cpu


@pytest.mark.parametrize(
    ("flags", "missing"),
    [
        ("fpu sse2 avx avx2 fma bmi2", []),
        ("fpu sse2 avx", ["avx2", "fma"]),
        ("fpu sse2 avx avx2 fma4", ["fma"]),
    ],
)
def test_missing_instruction_sets_are_found(flags: str, missing: list[str]) -> None:
    assert _cpu.missing_flags(f"processor\t: 0\nflags\t\t: {flags}\nbugs\t\t: avx2 fma\n") == missing


def test_a_machine_without_flags_line_is_not_refused() -> None:
    assert _cpu.missing_flags("Hardware\t: something else\n") == []


def test_this_machine_is_accepted() -> None:
    _cpu.require_supported_processor()


@pytest.mark.skipif(os.uname().machine != "x86_64", reason="the check is for x86-64 Linux")
def test_old_processors_get_an_import_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_cpu, "missing_flags", lambda cpuinfo: ["avx2"])
    with pytest.raises(ImportError, match=r"AVX2 and FMA.*lacks avx2"):
        _cpu.require_supported_processor()
