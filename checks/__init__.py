"""What records show of their sensors and files without a hull model."""
