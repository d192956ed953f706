"""Order conditions of a black box: one step on the universal SDE of a class gives every elementary weight.

The components of the `universal` SDE are rooted trees whose nodes are drift, noise or time (`grow`). The increment of
each component in a step (`weights`) is compared with the exact solution: path by path, as far as the noise of a step
determines it (`record`), and in the mean (`moments`). Relations between elementary differentials define classes
(`classes`). A form defines classes of its own by `sdaeverify.trees`.
"""
