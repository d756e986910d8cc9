"""How far a run can be trusted: energy balance, time error, compression."""
