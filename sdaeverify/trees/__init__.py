"""Order conditions of a black box: one step on the universal SDE of a class tells every elementary weight.

Rooted trees whose nodes are drift, noise or time (`grow`) are the components of the `universal` SDE; what a step
makes of each of them (`weights`) is compared with the exact solution, path by path as far as the noise of a step
tells it (`record`), and in the mean (`moments`). Relations between elementary differentials make classes (`classes`).

A form of one's own has order conditions as soon as it offers a class of its equations::

    class Mine(Problem):
        @classmethod
        def tree_classes(cls):
            return (MyTrees(),)                   # a TreeClass: kinds of nodes, a problem for given trees, relatives

Where it has `written` too, a failing condition can be written as a plugin file. `Langevin` and `IndexOneSDAE` do the
same; these are the names that such a class is written with. Where order conditions are not known, a form offers a
class of its equations from which random members are drawn, a `GenericClass`, in the same way::

        @classmethod
        def generic_classes(cls):
            return (GenericClass("Mine", draw, FEATURES),)    # draw(generator, without) returns a problem
"""

from ..forms.generic import GenericClass
from ..forms.tree_class import Grove, Grown, Node, Posed, Relatives, TreeClass, Written

__all__ = ["GenericClass", "Grove", "Grown", "Node", "Posed", "Relatives", "TreeClass", "Written"]
