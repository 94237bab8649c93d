"""Likelihoods of single methods: prediction errors, moving horizon, posterior samples, profiles, priors as options."""
