"""How a cause is looked for: score, profile, change point, scan."""
