"""Linear problems without sampling: the linear map of a step, and exact moments along a run."""
