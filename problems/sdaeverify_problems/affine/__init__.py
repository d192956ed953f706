"""A constraint that is affine, whose laws are all normal."""
