"""Readers of files of one make each: their formats state quantities, units and signs."""
