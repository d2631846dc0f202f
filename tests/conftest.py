"""Signals as in a terminal: what a script starts in the background ignores Ctrl-C, and so would the processes
that tests start and interrupt."""

import signal

signal.signal(signal.SIGINT, signal.default_int_handler)
