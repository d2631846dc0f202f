"""Scenes that are meant to break Stark, each with a small and a full size, judged by the independent package
ipctk: tests/torture runs the small ones, ``python -m benchmarks.torture`` the full ones and random ones."""
