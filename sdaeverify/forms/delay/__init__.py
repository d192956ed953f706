"""Index-1 equations with one constant delay: the form, its meshes, checks and dissipation constants."""
