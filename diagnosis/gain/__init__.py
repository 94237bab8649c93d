"""Free runs before and after, and the extended model."""
