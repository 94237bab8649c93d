"""From manoeuvring indices to a model: indices as given, indices of a model, and the fit between the two."""
