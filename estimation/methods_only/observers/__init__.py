"""The extended state observer."""
