"""Tuning of a method's options: search spaces as data, samplers, studies that several machines may share."""
