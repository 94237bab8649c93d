"""What a simulation gets wrong about measured records: the cause, the extended model, the gain."""
