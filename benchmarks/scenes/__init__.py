"""The scenes that are measured side by side with the public implementation of the paper."""
