"""Order conditions of a black box: one step on the universal SDE of a class tells every elementary weight.

Rooted trees whose nodes are drift, noise or time (`grow`) are the components of the `universal` SDE; what a step
makes of each of them (`weights`) is compared with the exact solution, path by path as far as the noise of a step
tells it (`record`), and in the mean (`moments`). Relations between elementary differentials make classes (`classes`).
"""
