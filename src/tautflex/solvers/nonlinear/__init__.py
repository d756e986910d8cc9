"""Newton's method, Anderson acceleration and minima."""
