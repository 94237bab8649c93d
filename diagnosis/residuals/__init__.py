"""What no named cause explains."""
