"""The open exam: sealed worlds with hidden changes, answered in a neutral format, scored with a key.

The worlds are cases of a diagnosis suite (`kinds.diagnosis`) on ships of their own.
"""
