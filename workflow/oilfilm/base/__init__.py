"""What every room may use: errors, units, files, digests, ties of numbers, figures, studies."""
