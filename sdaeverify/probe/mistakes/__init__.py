"""Common mistakes in schemes, as what they make of the rates and the noise of an equation."""
