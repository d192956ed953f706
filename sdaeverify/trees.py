"""The public names for authors of forms whose equations have order conditions, or random members.

A form has order conditions if it offers a class of its equations::

    class Mine(Problem):
        @classmethod
        def tree_classes(cls):
            return (MyTrees(),)                   # a TreeClass: kinds of nodes, a problem for given trees, relatives

If the class has `written`, a failing condition can be written as a plugin file; the module `far_problems` draws what
`TreeClass.distant` needs. `Langevin` and `IndexOneSDAE` are examples. If order conditions are not known, a form can
offer a `GenericClass`, from which random members are drawn::

        @classmethod
        def generic_classes(cls):
            return (GenericClass("Mine", draw, FEATURES),)    # draw(generator, without) returns a problem

The plugin `sdaeverify_orders` tests claims on these classes.
"""

from .forms.generic import GenericClass
from .forms.trees import far_problems
from .forms.trees.tree_class import Grove, Grown, Node, Posed, Relatives, TreeClass, Written

__all__ = ["GenericClass", "Grove", "Grown", "Node", "Posed", "Relatives", "TreeClass", "Written", "far_problems"]
