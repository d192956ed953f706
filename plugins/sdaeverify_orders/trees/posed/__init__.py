"""Order conditions for classes that a form defines, with other nodes than drift, noise and time."""
