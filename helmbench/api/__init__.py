"""What the public names of helmbench do that belongs to no single room; `import helmbench` offers it."""
