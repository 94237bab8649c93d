"""What methods and diagnosis share: records as arrays, regressions, filters, likelihoods, observers, tuning."""
