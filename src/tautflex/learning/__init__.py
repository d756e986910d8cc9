"""Learning to hold an antenna still: tasks, environments, training, judging [control.md 5]."""
