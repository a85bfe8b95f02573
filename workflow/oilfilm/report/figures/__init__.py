"""Figures: one function per figure, from finished tables to the figure and what it draws."""
