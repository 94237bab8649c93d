"""What a fit gives: coefficients or a predictor."""
