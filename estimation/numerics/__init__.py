"""What fits compute with: triangular factors of linear problems, threads."""
