"""The papers' methods against their baselines on every vessel."""
