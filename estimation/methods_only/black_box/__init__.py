"""Black boxes: scikit-learn regressors of accelerations, simulated like a model."""
