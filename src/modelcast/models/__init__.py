"""Motion models: a model is fitted to windows and predicts displacements."""
