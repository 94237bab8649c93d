"""Pages and tables of `check`."""
