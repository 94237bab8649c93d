"""The benchmark of diagnosis: the truth simulator injects effects, a diagnoser is run, its findings are scored."""
