"""
Work and precision
==================

Which scheme needs the least work for an accuracy? Errors are compared on the same noise, the work is the measured
time of the steps of a path. Each scheme stands beside what it claims and what was found of that: the slope of its
line is minus its order, as far as a step costs the same at all step sizes.
"""

from matplotlib import pyplot as plt

from sdaeverify import verify

result = verify("euler-maruyama,milstein,heun", "gbm", "strong", paths=2048, levels=5)
result.plot.work("gbm")
plt.show()

# %%
# In numbers: steps and noise for an error of 0.02. Where the finest step size is too coarse, the order says how many
# steps are needed.

found = {one.scheme: one for one in result.choose("gbm", accuracy=0.02).found}
for name, one in found.items():
    print(f"{name}: {'about ' * one.beyond}{one.steps:.0f} steps, noise {one.noise}, {one.verdict}")

# %%
# The schemes of order 1 need fewer steps than that of order 1/2.

assert found["milstein"].steps < found["euler-maruyama"].steps
assert found["heun"].steps < found["euler-maruyama"].steps
