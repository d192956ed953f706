"""Linear problems without sampling: the linear map of a step, and the exact moments of a run."""
