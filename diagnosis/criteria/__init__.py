"""What candidates are judged by: residuals of the filter, marginal likelihood, free runs of left-out records."""
