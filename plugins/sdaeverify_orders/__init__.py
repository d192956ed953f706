"""Claims about classes of equations: order conditions by rooted trees, random members of forms, modified equations.

::

    from sdaeverify_orders import modified_equations, orders

    report = orders("milstein", "scalar")                     # report.table, report.failing
    (shadow,) = modified_equations("euler-maruyama", "overdamped-gradient")

Both functions are also attributes of `sdaeverify`. A run tests all claims of its schemes on classes by `order_tests`,
an entry point of the group ``sdaeverify.classes``.
"""

from .modified_equations import modified_equations
from .order_report import orders

__all__ = ["modified_equations", "orders"]

# An error of a scheme names the line of the scheme, not that of the test that called it.
CALLS_PLUGINS = True
