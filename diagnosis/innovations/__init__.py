"""What the innovations of a filter say, beside an exact base model or where records allow no pieces."""
