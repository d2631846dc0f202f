"""The same scenes in other simulators, each in an environment of its own."""
