"""Score tests, their levels, and penalised log likelihoods under random forces."""
