"""The reproduction of one paper: its claims, printed constants, advice, figures and tables."""
