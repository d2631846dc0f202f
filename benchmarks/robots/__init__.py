"""Robots of packages of PyPI, read by stark and compared with pinocchio and mujoco."""
