"""From records to linear regressions, and their least-squares solutions."""
