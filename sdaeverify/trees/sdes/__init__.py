"""Equations of classes of SDEs: the universal one, two that an affine map relates, one with rich diagonal noise."""
