"""
Work and precision
==================

Which scheme needs the least work for an accuracy? Errors are compared on the same noise, and the work is the
measured time of the steps of a path. The legend has the claim of each scheme and its verdict. The slope of a line is
minus the order of the scheme if steps of all sizes take the same time.
"""

from matplotlib import pyplot as plt

from sdaeverify import verify

result = verify("euler-maruyama,milstein,heun", "gbm", "strong", paths=2048, levels=5)
result.plot.work("gbm")
plt.show()

# %%
# Steps and noise needed for an error of 0.02. If the finest step size is too coarse, the number of steps is
# extrapolated with the order.

found = {one.scheme: one for one in result.choose("gbm", accuracy=0.02).found}
for name, one in found.items():
    print(f"{name}: {'about ' * one.beyond}{one.steps:.0f} steps, noise {one.noise}, {one.verdict}")

# %%
# The schemes of order 1 need fewer steps than that of order 1/2.

assert found["milstein"].steps < found["euler-maruyama"].steps
assert found["heun"].steps < found["euler-maruyama"].steps
