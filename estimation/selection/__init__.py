"""Which numbers explain records: normal equations by unit, left-out scores, and the smallest set that is not worse."""
