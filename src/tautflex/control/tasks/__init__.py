"""Tasks for control laws and agents: what is paid, what is drawn, and what a policy sees."""
