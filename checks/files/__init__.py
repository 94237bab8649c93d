"""Checks of one record's file: one class in one file each."""
