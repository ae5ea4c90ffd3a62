"""From samples as they come to the window a sub-model is fitted to; all of it causal."""
