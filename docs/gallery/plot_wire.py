r"""
A program in C
==============

A solver need not be in Python. This solver is a C program that reads the data of a step on its stdin, requests the
drift, the diffusion and its derivative at the states, and writes the new states to its stdout:

.. math::

    x^{+} = x + h f(x) + B(x) \,\Delta W + \tfrac12 B'(x) B(x) (\Delta W^2 - h)

It includes the header that ``sdaeverify wire --client c`` prints. Compiled with ``-DSIGN=-``, its last term has the
wrong sign. Without a C compiler this example runs nothing.
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

from matplotlib import pyplot as plt

import sdaeverify_wire
from sdaeverify import verify
from sdaeverify_orders import orders
from sdaeverify_wire import scheme_of

COMPILER = shutil.which("gcc")
header = Path(sdaeverify_wire.__file__).parent / "clients"
source = Path("../../tests/wire/programs/wired_milstein.c")
folder = Path(tempfile.mkdtemp())


def built(name, sign):
    """Return the scheme of the program with a sign of its last term."""
    program = folder / name
    subprocess.run([COMPILER, "-O2", f"-I{header}", f"-DSIGN={sign}", source, "-o", program], check=True)
    return scheme_of(program)


print(source.read_text())

# %%
# The hello of the program declares its name, the traits that it needs, and its claims. On geometric Brownian motion
# both orders are verified; the wrong sign is refuted.

if COMPILER:
    right, wrong = built("right", "+"), built("wrong", "-")
    found = {sign: verify([each], "gbm", "strong,weak") for sign, each in (("+", right), ("-", wrong))}
    for sign, result in found.items():
        print(sign, result.verdicts[["measure", "quantity", "verdict", "reason"]].to_string(index=False))
    assert "refuted" not in set(found["+"].verdicts.verdict)
    assert set(found["-"].verdicts.query("measure == 'strong'").verdict) == {"refuted"}

# %%
# The errors along paths of the two programs.

if COMPILER:
    figure, ax = plt.subplots(figsize=(6, 3), layout="constrained")
    for sign, result in found.items():
        levels = result.levels.query("measure == 'strong' and quantity == 'x@T'")
        ax.loglog(levels.h, levels.estimate, "o-", label=f"sign {sign}")
    ax.set(xlabel="h", ylabel="error at the end")
    ax.legend()

# %%
# One step on the equation of rooted trees identifies the wrong term. The program needs no code for this.

if COMPILER:
    print(orders(wrong, "scalar"))
