"""Forward selection of causes."""
