"""Free runs of pieces of records, or of whole ones, as the problem of a fit or a selection in any numbers."""
