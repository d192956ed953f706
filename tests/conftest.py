"""What all tests share: runs of pytest inside a test, and compiled modules for the programs that tests start."""

import os
import sys

pytest_plugins = "pytester"

# Where the environment says that nothing compiled be kept, each of the hundred programs that tests start compiles the
# package anew, for half a second. Git ignores what is kept.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
