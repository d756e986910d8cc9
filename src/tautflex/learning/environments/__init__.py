"""Episodes of tasks: single and vector environments of Gymnasium, and the array program behind them."""
