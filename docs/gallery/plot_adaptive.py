"""
Fixed against adaptive steps
============================

Does it pay to choose the steps? Heun's scheme with steps of one length, and with an embedded estimate and a
controller, on the same Brownian paths. The first equation is stiff, dx = -40 x dt + 0.7 dW: explicit steps have to be
short enough to be stable, and a controller finds that out. The second one grows with heavy tails, dx = 2 x dt + x dW:
paths differ in size by orders of magnitude, and most of the error is made on few of them.
"""

import numpy as np
from matplotlib import pyplot as plt

from sdaeverify.commands import load_and_warn
from sdaeverify.studying import select_problems, select_schemes
from sdaeverify_adaptive.path import brownian_path
from sdaeverify_adaptive.sample import Budget, fixed, measure, truth

registry = load_and_warn((), lab=True)
heun, adaptive = select_schemes(registry, "heun")[0], registry.things("sdaeverify_adaptive")["heun-pi"]
budget = Budget(paths=100, tolerances=tuple(2.0**-n for n in (3, 5, 7, 9, 11)))


def sizes(errors):
    """Return the root of the mean square, and the median."""
    found = np.sqrt(np.sum(errors**2, axis=0))
    return np.sqrt(np.mean(found**2)), np.median(found)


# %%
# Tries are counted, rejected ones too: each costs two evaluations of the coefficients. Where 16 fixed steps are
# unstable, no point is shown. On the stiff equation the noise is additive and the same everywhere: there is nothing
# to be gained but stability, and a try that is rejected is lost.

figure, axes = plt.subplots(1, 2, figsize=(8, 3.4), layout="constrained")
for label, ax in zip(("ou[a=40]", "gbm-heavy"), axes, strict=True):
    problem = select_problems(registry, label)[0].build()
    found = measure(adaptive, problem, budget, label)
    path = brownian_path(next(budget.sources(label)), 1, problem.horizon)
    exact, steps = truth(problem, path), (16, 64, 256, 1024)
    ends = [fixed(heun, problem, path, n) - exact for n in steps]
    for name, tries, errors in (("fixed", steps, ends), ("adaptive", found.tries.mean(axis=-1), found.errors)):
        rms, median = np.transpose([sizes(each) for each in errors])
        (line,) = ax.loglog(tries, np.where(rms < 1e3, rms, np.nan), "o-", label=f"{name}, rms")
        ax.loglog(tries, np.where(median < 1e3, median, np.nan), ":", color=line.get_color(), label=f"{name}, median")
    ax.set(title=label, xlabel="tries a path", ylabel="error at the end")
axes[0].legend(fontsize="small")
plt.show()

# %%
# A tolerance that keeps its promise is another question than one that pays. It is asked by `sdaeverify adaptive`.
