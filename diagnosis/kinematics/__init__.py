"""What the channels say of each other, without a hull model."""
