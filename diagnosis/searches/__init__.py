"""How a cause is looked for: score, rings, profile, change point, scan."""
