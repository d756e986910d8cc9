"""The paper, computed again: its tables as data, the runs behind them, the comparison, figures and a page."""
