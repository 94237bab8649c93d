"""Sensor errors that show between channels: one class in one file each."""
