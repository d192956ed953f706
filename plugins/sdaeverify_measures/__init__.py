"""Families of stiff problems: errors over the stiffness parameter eps."""
