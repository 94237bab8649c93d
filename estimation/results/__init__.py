"""What a fit gives: coefficients or a predictor, and the predictions of records with either."""
