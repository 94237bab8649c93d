"""Records as estimation takes them: series of arrays, measured weather, gaps and splices, names."""
