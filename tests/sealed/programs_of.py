"""Programs that are sealed solvers of ou, in the languages that are installed."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAMS = Path(__file__).parent / "programs"


def need(tool):
    """Skip a test where a compiler or interpreter is not installed."""
    if shutil.which(tool) is None:
        pytest.skip(f"{tool} is not installed")
    return tool


def in_c(folder):
    """Return Euler's scheme in C as a command."""
    program = folder / "euler_ou"
    warnings = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
    command = [need("gcc"), *warnings, str(PROGRAMS / "euler_ou.c"), "-o", str(program), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    return [str(program)]


def in_r(folder):
    """Return Euler's scheme in R, without packages, as a command."""
    return [need("Rscript"), "--vanilla", str(PROGRAMS / "euler_ou.R")]


def in_python(folder, body):
    """Return a program of a few lines of Python as a command: `given` holds the words, `write` takes numbers."""
    text = f"""import os, random, struct, sys, time
given = dict(word.split("=") for word in sys.argv[1:])
paths = int(given["paths"])
def write(*numbers):
    sys.stdout.buffer.write(struct.pack(f"<{{len(numbers)}}d", *numbers))
    sys.stdout.buffer.flush()
{body}
"""
    program = folder / "program.py"
    program.write_text(text)
    return [sys.executable, "-E", "-S", str(program)]
