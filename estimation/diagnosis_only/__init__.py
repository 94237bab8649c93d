"""What a diagnosis fits with and no identification method does."""
