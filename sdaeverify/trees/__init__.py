"""Order conditions of a black box: one step on the universal SDE of a class gives every elementary weight.

The components of the `universal` SDE are rooted trees whose nodes are drift, noise or time (`grow`). The increment of
each component in a step (`weights`) is compared with the exact solution: path by path, as far as the noise of a step
determines it (`record`), and in the mean (`moments`). Relations between elementary differentials define classes
(`classes`).

A form defined by a plugin has order conditions if it offers a class of its equations::

    class Mine(Problem):
        @classmethod
        def tree_classes(cls):
            return (MyTrees(),)                   # a TreeClass: kinds of nodes, a problem for given trees, relatives

If the class has `written`, a failing condition can be written as a plugin file. `Langevin` and `IndexOneSDAE` are
examples; the public names of this package serve to define such a class. If order conditions are not known, a form can
offer a `GenericClass`, from which random members are drawn::

        @classmethod
        def generic_classes(cls):
            return (GenericClass("Mine", draw, FEATURES),)    # draw(generator, without) returns a problem
"""

from ..forms.generic import GenericClass
from ..forms.tree_class import Grove, Grown, Node, Posed, Relatives, TreeClass, Written

__all__ = ["GenericClass", "Grove", "Grown", "Node", "Posed", "Relatives", "TreeClass", "Written"]
