"""Mean-square stability: spectral radii of second-moment operators, and windows of step sizes."""
