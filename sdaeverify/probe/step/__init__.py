"""One step as a black box: its map, cubature nodes for its noise, and the states and times at which it is probed."""
