"""
Fixed against adaptive steps
============================

When are adaptive steps more efficient? This example compares Heun's scheme with fixed steps and with an embedded
error estimate and a controller, on the same Brownian paths. The first equation is stiff, dx = -40 x dt + 0.7 dW:
explicit steps have to be short enough to be stable, and the controller finds a stable length. The second one grows
with heavy tails, dx = 2 x dt + x dW: paths differ in size by orders of magnitude, and most of the error is made on
few of them. The third one has two time scales, dx = r(t) (sin 6 t - x) dt + dW/2: the rate r is 1 but for a hundredth
of the time, when it is up to 300.
"""

import numpy as np
from matplotlib import pyplot as plt

from sdaeverify import SDE
from sdaeverify.commands import load_and_warn
from sdaeverify.studying import select_problems, select_schemes
from sdaeverify_adaptive.path import brownian_path
from sdaeverify_adaptive.sample import Budget, fixed, solved, truth

registry = load_and_warn((), lab=True)
heun, adaptive = select_schemes(registry, "heun")[0], registry.things("sdaeverify_adaptive")["heun-pi"]
budget = Budget(paths=100, tolerances=tuple(2.0**-n for n in (3, 5, 7, 9, 11)))


def two_scales():
    """Return a slow equation with a short time in which it is fast."""

    def rate(t):
        return 1.0 + 300.0 * np.exp(-(((t - 0.5) / 0.01) ** 2))

    return SDE(
        drift=lambda t, x: rate(t) * (np.sin(6.0 * t) - x),
        diffusion=lambda t, x: 0.5 + 0.0 * x[:, None],
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="made for this page",
        traits=frozenset({"additive-noise"}),
    )


def sizes(errors):
    """Return the root of the mean square, and the median."""
    found = np.sqrt(np.sum(errors**2, axis=0))
    return np.sqrt(np.mean(found**2)), np.median(found)


# %%
# The work is the number of attempted steps, including rejected ones: each costs two evaluations of the coefficients.
# Points where fixed steps are unstable are not shown. On the stiff equation the noise is additive and constant, so
# that the controller gains only stability, and rejected steps are lost. With two time scales, short steps are needed
# only for a short time, and the controller needs about a third of the steps for the same error. At the larger
# tolerances it misses this time on some paths, so that the root mean square error is far above the median. The truth
# of the third equation is 2^13 fixed steps.

problems = {label: select_problems(registry, label)[0].build() for label in ("ou[a=40]", "gbm-heavy")}
problems["two time scales"] = two_scales()
figure, axes = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
for (label, problem), ax in zip(problems.items(), axes, strict=True):
    path = brownian_path(next(budget.sources(label)), 1, problem.horizon)
    exact = truth(problem, path) if problem.pathwise else fixed(heun, problem, path, 2**13)
    steps = (16, 64, 256, 1024)
    chosen = [solved(adaptive, problem, path, tolerance) for tolerance in budget.tolerances]
    runs = {
        "fixed": (steps, [fixed(heun, problem, path, n) for n in steps]),
        "adaptive": ([np.mean(run.steps + run.rejected) for run in chosen], [run.state for run in chosen]),
    }
    for name, (tries, ends) in runs.items():
        rms, median = np.transpose([sizes(end - exact) for end in ends])
        (line,) = ax.loglog(tries, np.where(rms < 1e3, rms, np.nan), "o-", label=f"{name}, rms")
        ax.loglog(tries, np.where(median < 1e3, median, np.nan), ":", color=line.get_color(), label=f"{name}, median")
    ax.set(title=label, xlabel="tries a path", ylabel="error at the end")
axes[0].legend(fontsize="small")
plt.show()

# %%
# Whether the error falls with the tolerance as claimed is another question: `sdaeverify adaptive` tests it.
