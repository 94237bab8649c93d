"""Paper 002: fast convergent iterative learning least squares (FCI-LS) on response models, and a tank test."""
