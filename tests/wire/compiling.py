"""Programs in other languages, built where their compiler is installed."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import sdaeverify_wire

PROGRAMS = Path(__file__).parent / "programs"
CLIENTS = Path(sdaeverify_wire.__file__).parent / "clients"
# A machine may fuse a product with a sum, which rounds once and not twice: the bits would be others.
FLAGS = ("-O2", "-ffp-contract=off", f"-I{CLIENTS}")


def need(tool):
    """Skip a test where a compiler or interpreter is not installed."""
    if shutil.which(tool) is None:
        pytest.skip(f"{tool} is not installed")
    return tool


def run(*command):
    """Run a compiler, whose warnings are errors of the test."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr


def built_c(folder, name, *flags):
    """Return a program in C as a command."""
    program = folder / name
    warnings = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
    run(need("gcc"), *warnings, *FLAGS, *flags, str(PROGRAMS / f"{name}.c"), "-o", str(program), "-lm")
    return [str(program)]


def built_cpp(folder):
    """Return golden-euler, which is also C++, as a command."""
    program, source = folder / "golden_euler_cpp", PROGRAMS / "golden_euler.c"
    run(need("g++"), "-x", "c++", "-Wall", "-Wextra", "-Werror", *FLAGS, str(source), "-o", str(program))
    return [str(program)]


def built_fortran(folder):
    """Return golden-euler in Fortran as a command: the header is compiled once, with its functions visible."""
    program, header, unit = folder / "golden_euler_f", folder / "wire.o", folder / "wire.c"
    unit.write_text('#include "sdaeverify.h"\n')
    run(need("gcc"), *FLAGS, "-DSV_API=", "-c", str(unit), "-o", str(header))
    source = str(PROGRAMS / "golden_euler.f90")
    run(need("gfortran"), *FLAGS, f"-J{folder}", source, str(header), "-o", str(program))
    return [str(program)]


def with_python(folder, name="golden_euler"):
    """Return a program in Python, beside the client, as a command."""
    for file in (CLIENTS / "sdaeverify_client.py", PROGRAMS / f"{name}.py"):
        shutil.copy(file, folder)
    return [sys.executable, "-E", "-S", str(folder / f"{name}.py")]


def with_octave(_, name="golden_euler"):
    """Return a program in Octave, which finds the client, as a command."""
    need("octave-cli")
    return ["octave-cli", "--no-gui", "--norc", "-q", "-p", str(CLIENTS), str(PROGRAMS / f"{name}.m")]


def with_r(_, name="golden_euler"):
    """Return a program in R, which is told where the client is, as a command."""
    need("Rscript")
    return ["Rscript", "--vanilla", str(PROGRAMS / f"{name}.R"), str(CLIENTS / "sdaeverify.R")]


LANGUAGES = {
    "C": lambda folder: built_c(folder, "golden_euler"),
    "C++": built_cpp,
    "Fortran": built_fortran,
    "Octave": with_octave,
    "Python": with_python,
    "R": with_r,
}
