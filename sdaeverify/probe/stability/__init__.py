"""Mean-square stability: spectral radii of second-moment operators, and windows of stable step sizes."""
