"""Equations of classes of SDEs: the universal one, two related by an affine map, one with rich diagonal noise."""
